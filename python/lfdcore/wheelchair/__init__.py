"""The powered wheelchair: the drive loop, assistants, and a folder for each way to infer the driver (Ch. 2-4)."""
