"""What lfdcore predict judges and draws: predicted paths along recorded drives (Sec. 3.5.2, Fig. 3.16)."""
