"""A file a `lfdcore learn`; `parts` of them; `estimators`: models of the core for other frameworks."""
