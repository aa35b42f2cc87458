"""lfdcore predict: a posteriori along real logs."""


def predict() -> None:
    """Placeholder until the prediction study is merged."""
