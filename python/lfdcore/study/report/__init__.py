"""What every report is made of: tables, cells, aims, statistics, one HTML page."""
