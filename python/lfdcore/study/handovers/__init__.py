"""lfdcore study handovers: the taker's motion predicted from the giver's, on real data (Sec. 5.3, 6.2.2)."""
