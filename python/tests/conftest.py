"""Settings of the tests."""

import hypothesis

# The same cases every time; a failure is not a matter of luck.
hypothesis.settings.register_profile("pickline", derandomize=True, deadline=None, max_examples=60)
hypothesis.settings.load_profile("pickline")
