"""Three methods compared along unassisted drives, a posteriori (Sec. 4.6.2, Table 4.2): a part of the demo."""
