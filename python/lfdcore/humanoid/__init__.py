"""Two arms that help a person: Baxter and the tasks of Ch. 5."""
