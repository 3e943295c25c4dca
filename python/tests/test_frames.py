"""Tables for pandas, polars and Arrow, and patterns from their data frames."""

import sys

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import pickline


@pytest.fixture(scope="module")
def compared():
    return pickline.compare(replicates=2, robust="SPT,FIFO", greedy=False, policy=False, bound=False)


@pytest.fixture(scope="module")
def found():
    return pickline.optimize(patterns="grid:0.2", items=20, validate=0, bound=False)


def test_tables_are_frames_of_pandas(compared, found):
    for table in (compared.runs, compared.picking_rate, found.ranking):
        frame = table.to_pandas()
        assert list(frame.columns) == list(table.to_dict()) and len(frame) == len(table)
        for name, values in table.to_dict().items():
            assert frame[name].tolist() == values.tolist() or values.dtype == np.float64
            if values.dtype == np.float64:
                assert np.array_equal(frame[name].to_numpy(), values, equal_nan=True)
    means = compared.runs.to_pandas().groupby("case", sort=False)["picking_rate_per_min"].mean()
    assert np.allclose(means, compared.picking_rate.picking_rate_per_min)


def test_readers_of_arrow_take_tables(compared, found):
    for table in (compared.runs, compared.picking_rate, found.ranking):
        for frame in (polars.DataFrame(table), polars.from_arrow(pyarrow.table(table))):
            assert frame.columns == list(table.to_dict()) and frame.height == len(table)
            for name, values in table.to_dict().items():
                assert np.array_equal(
                    frame[name].to_numpy(), values, equal_nan=values.dtype == np.float64
                )
    kinds = polars.DataFrame(found.ranking).schema
    assert kinds["rank"] == polars.Int64 and kinds["tied"] == polars.Boolean
    assert kinds["assignment"] == polars.String and kinds["picked_share"] == polars.Float64
    # The reader has the memory, so the table may go.
    table = pyarrow.table(pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.15, 50)).picks)
    assert table["item"].to_pylist()[:2] == sorted(table["item"].to_pylist()[:2])
    assert table.num_rows > 30


def test_tables_without_rows_are_frames_too():
    run = pickline.simulate("paper", pickline.Pattern.grid(1.05, 0.15, 20), "SPT,FIFO")
    assert len(run.failures) == 0
    assert polars.DataFrame(run.failures).schema["grasp"] == polars.Float64
    assert run.failures.to_pandas().shape == (0, 8)


def test_without_pandas_there_is_a_cure(compared, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="cure: pip install pandas"):
        compared.runs.to_pandas()


COLUMNS = {
    "id": ["a", "b", "c"],
    "x": [0.0, -0.5, -1.0],
    "y": [0.1, 0.2, 0.3],
    "weight": [None, 2.0, None],
    "class": [None, "pet", None],
}


@pytest.mark.parametrize("frame", [pandas.DataFrame, polars.DataFrame])
def test_patterns_are_read_from_frames(frame):
    pattern = pickline.Pattern.from_frame(frame(COLUMNS))
    same = pickline.Pattern(
        COLUMNS["x"],
        COLUMNS["y"],
        id=COLUMNS["id"],
        weight=COLUMNS["weight"],
        item_class=COLUMNS["class"],
    )
    assert pattern == same and pattern.item_class == [None, "pet", None]
    numbered = pickline.Pattern.from_frame(frame({"id": [7, 8], "x": [0, -1], "y": [0.1, 0.2]}))
    assert numbered.id == ["7", "8"]


@pytest.mark.parametrize("frame", [pandas.DataFrame, polars.DataFrame])
@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"x": [0.0]}, "no column `y`"),
        ({"x": [0.0], "y": [0.0], "wieght": [1.0]}, "no column `wieght`"),
        ({"x": [float("nan")], "y": [0.0]}, "NaN"),
        ({"x": [0.0], "y": [0.0], "p_grasp": [2.0]}, "p_grasp"),
    ],
)
def test_other_frames_are_refused(frame, columns, words):
    with pytest.raises(ValueError) as raised:
        pickline.Pattern.from_frame(frame(columns))
    assert words in str(raised.value) and "cure: " in str(raised.value)


def test_patterns_are_read_from_tables_of_arrow():
    read = pickline.Pattern.from_frame(polars.DataFrame(COLUMNS).to_arrow())
    assert read == pickline.Pattern.from_frame(polars.DataFrame(COLUMNS))


def test_frames_that_have_no_place_for_an_item_are_refused():
    twice = pandas.DataFrame([[0.0, 0.1, 0.2]], columns=["x", "y", "x"])
    with pytest.raises(ValueError, match="two columns are called `x`\n  cure: "):
        pickline.Pattern.from_frame(twice)
    nulls = pandas.DataFrame({"x": pandas.array([0, pandas.NA], dtype="Int64"), "y": [0.0, 0.1]})
    for frame in (nulls, polars.DataFrame({"x": [0, None], "y": [0.0, 0.1]})):
        with pytest.raises(ValueError, match="row 1 has no `x`\n  cure: "):
            pickline.Pattern.from_frame(frame)
    with pytest.raises(TypeError, match="LazyFrame.* has no values yet\n  cure: call its `collect`"):
        pickline.Pattern.from_frame(polars.LazyFrame(COLUMNS))


def test_missing_values_of_pandas_are_unknown():
    frame = pandas.DataFrame({"x": [0.0, -1.0], "y": [0.0, 0.0]}).assign(
        weight=pandas.array([pandas.NA, 3], dtype="Int64"), p_grasp=[np.nan, 0.5]
    )
    pattern = pickline.Pattern.from_frame(frame)
    assert pattern.reward.tolist() == [0.5, 3.0]
    with pytest.raises(TypeError, match="has no columns"):
        pickline.Pattern.from_frame([1, 2])
