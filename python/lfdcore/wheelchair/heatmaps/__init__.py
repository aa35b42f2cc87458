"""Ch. 4: heatmaps from a scan and a stick, and the path over their product."""
