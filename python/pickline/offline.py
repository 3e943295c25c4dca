"""Data for learning offline: episodes of strategies as Minari datasets."""

from __future__ import annotations

import copy
import json
import os
import shutil
from collections.abc import Iterable
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium import spaces

from pickline import _pickline
from pickline._arguments import checked
from pickline._parts import (
    PAPER_REWARD,
    ObservationName,
    as_patterns,
    as_reward,
    as_slots,
    observation_space,
)
from pickline._pickline import Pattern, Station
from pickline._progress import Progress, watcher
from pickline._registration import ENVIRONMENT_ID
from pickline._strategies import Strategy
from pickline.conditions import Conditions, conditions
from pickline.result import call_text
from pickline.simulation import as_station

__all__ = ["to_minari"]


@checked(Conditions)
def to_minari(
    dataset_id: str,
    strategy: Strategy,
    station: Station | str | os.PathLike[str] = "paper",
    patterns: Pattern | Iterable[Pattern] | str = "poisson:0.12:100",
    *,
    items: int = 50,
    pattern_seed: int = 1,
    observation: ObservationName = "full",
    slots: int | None = None,
    wait: bool = False,
    reward: tuple[float, float] = PAPER_REWARD,
    seed: int = 1,
    progress: Progress = False,
    author: str | None = None,
    author_email: str | None = None,
    code_permalink: str | None = None,
    description: str | None = None,
    **under: Unpack[Conditions],
) -> Any:
    """Write what a strategy does as a Minari dataset, one episode for each pattern.

    Observations, actions, masks, rewards and the end of an episode are those of
    :class:`pickline.SortingEnv` with the same arguments. ``lookahead`` is an expert to learn from,
    ``onnx`` is of medium skill, and rules such as ``SPT,FIFO`` are simple.

    A strategy may do what the environment has no action for: take an item that is in no slot, or wait
    without ``wait``. It is done, and has no row. Its reward belongs to the row before it (or to the
    first one), so the rewards add up to those of the run. How many decisions that are is ``left_out`` in
    the metadata of the dataset and of each episode: more ``slots``, or ``wait``, leave out fewer. A wait
    of any length is the action to wait.

    Needs the package minari: ``pip install 'minari[hdf5]' pillow``.

    Args:
        dataset_id: ``NAMESPACE/NAME-vN``, with or without the namespace, such as
            ``"pickline/expert-v0"``. An existing dataset is not replaced.
        strategy: As for :func:`pickline.simulate`.
        station: As for the environment, as are ``patterns`` to ``reward``. Only if both are texts can
            ``dataset.recover_environment()`` make the environment.
        seed: Seed of the search for bases of a look-ahead that names none.
        progress: True for a bar by tqdm, or a callable; see :mod:`pickline`.
        author: For the metadata, as are the three after it.
        **under: Conditions of the episodes; see :class:`pickline.Conditions`.

    Returns:
        The ``minari.MinariDataset``. ``minari.load_dataset(dataset_id)`` reads it again. The metadata of
        an episode (``dataset.storage.get_episode_metadata``) has the index of its pattern and its
        figures; its ``infos`` have the ``action_mask`` at every step.

    Raises:
        ValueError: A value, a strategy or a pattern that does not fit the station, an episode of which
            nothing is an action of the environment, or a dataset that exists.
        OSError: A file that cannot be read or written.
        ImportError: Without minari.
        KeyboardInterrupt: Ctrl-C. No dataset is written.
    """
    call = call_text(to_minari, {name: value for name, value in locals().items() if value is not None})
    for name, text in dict(author=author, author_email=author_email, code_permalink=code_permalink).items():
        if text is not None and not isinstance(text, str):
            raise TypeError(f"{name}: {text!r} is not a text\n  cure: give a text, or leave it out")
    minari, folder = _free_place(dataset_id)
    line = as_station(station)
    given: dict[str, Any] = dict(items=items, pattern_seed=pattern_seed, observation=observation)
    given |= dict(slots=slots, wait=wait, reward=reward, **under)
    slots = as_slots(slots, observation)
    reward = as_reward(reward)
    drawn = as_patterns(patterns, line, items, pattern_seed)
    with watcher(progress) as watch:
        name, episodes = _pickline.demonstrate(
            line, drawn, strategy, conditions(**under), observation, slots, wait, reward, seed, watch
        )
    batch = _pickline.Batch(line, drawn, conditions(**under), observation, slots, wait, reward, 1)
    left_out = sum(episode["left_out"] for episode in episodes)
    decisions = left_out + sum(len(episode["actions"]) for episode in episodes)
    if description is None:
        description = (
            f"Episodes of {name}, made by {call}. {left_out} of {decisions} decisions are left out: what "
            "the strategy does there is not an action of the environment."
        )
    known = dict(author=author, author_email=author_email, code_permalink=code_permalink)
    try:
        dataset = minari.create_dataset_from_buffers(
            dataset_id,
            [_buffer(minari, episode) for episode in episodes],
            **_environment(station, patterns, given),
            action_space=spaces.Discrete(batch.actions),
            observation_space=observation_space(batch),
            algorithm_name=name,
            description=description,
            requirements=[f"pickline=={_pickline.__version__}"],
            **{key: value for key, value in known.items() if value is not None},
        )
        dataset.storage.update_metadata(dict(left_out=left_out, decisions=decisions, call=call))
        dataset.storage.update_episode_metadata(
            dict(pattern=place, left_out=episode["left_out"], **episode["figures"])
            for place, episode in enumerate(episodes)
        )
    except BaseException:
        # Nobody should load half a dataset.
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return dataset


def _free_place(dataset_id: str) -> tuple[Any, os.PathLike[str]]:
    """The package minari and where it will keep this dataset, before the work."""
    try:
        # What its storage needs, which it imports only when it writes.
        import h5py  # noqa: F401
        import minari
        import PIL  # noqa: F401
        from minari.dataset.minari_dataset import parse_dataset_id
        from minari.storage import get_dataset_path
    except ImportError as error:
        raise ImportError(
            f"to_minari: it needs minari: {error}\n  cure: pip install 'minari[hdf5]' pillow"
        ) from None
    try:
        parse_dataset_id(dataset_id)
    except (ValueError, TypeError):
        raise ValueError(
            f"dataset_id: {dataset_id!r} is not the name of a dataset\n"
            '  cure: give NAMESPACE/NAME-vN, such as "pickline/expert-v0", in names of two letters or more'
        ) from None
    folder = get_dataset_path(dataset_id)
    if os.path.exists(folder):
        raise ValueError(
            f"dataset_id: there is a dataset {dataset_id!r}\n"
            "  cure: give another version, or delete it with `minari delete`"
        )
    return minari, folder


def _buffer(minari: Any, episode: dict[str, Any]) -> Any:
    """An episode as Minari takes it."""
    ends = np.zeros(len(episode["actions"]), np.bool_)
    over = ends.copy()
    over[-1] = True
    return minari.data_collector.EpisodeBuffer(
        observations=episode["observations"],
        actions=episode["actions"],
        rewards=episode["rewards"],
        terminations=over,
        truncations=ends,
        infos={"action_mask": episode["masks"].astype(np.int8)},
    )


def _environment(station: Any, patterns: Any, given: dict[str, Any]) -> dict[str, Any]:
    """The environment of the dataset, if it can be written down."""
    # The registered one is everybody's.
    spec = copy.deepcopy(gymnasium.spec(ENVIRONMENT_ID))
    spec.kwargs = {"station": station, "patterns": patterns} | given
    try:
        json.dumps(spec.kwargs)
    except TypeError:
        return {}
    return dict(env=spec, eval_env=spec)
