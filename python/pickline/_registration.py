"""Registers the environments with Gymnasium."""

import gymnasium

ENVIRONMENT_ID = "pickline/Sorting-v0"


def register() -> None:
    """Register ``pickline/Sorting-v0``, once."""
    if ENVIRONMENT_ID not in gymnasium.registry:
        gymnasium.register(
            id=ENVIRONMENT_ID,
            entry_point="pickline.environment:SortingEnv",
            vector_entry_point="pickline.vector:SortingVectorEnv",
        )
