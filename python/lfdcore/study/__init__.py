"""Studies, a folder each, named as their commands; what they share stands beside the folders."""
