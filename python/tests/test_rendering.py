"""Pictures of the line, drawn by pygame without a screen."""

import os
import sys

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pickline
from pickline.rendering import BELT, ITEM, PAPER


def rgb(colour):
    return [int(colour[place : place + 2], 16) for place in (1, 3, 5)]


def environment(mode, **options):
    return gymnasium.make("pickline/Sorting-v0", render_mode=mode, **options).unwrapped


def test_items_are_where_they_are_until_they_are_grasped():
    env = environment("rgb_array", patterns="grid:0.3", items=30)
    _, info = env.reset(seed=1)
    at = env._painter._at
    ended, lifted = False, 0
    while not ended:
        picture, time = env.render(), env.time
        assert picture.dtype == np.uint8 and picture.shape[2] == 3
        picks = env.picks
        gone = {int(item) for item, grasp in zip(picks.item, picks.grasp, strict=True) if grasp <= time}
        fetched = {int(item) for item in picks.item} - gone
        hands = [env._painter._hand(i, robot, picks, time)[0] for i, robot in enumerate(env._painter._robots)]
        for item, (x0, y) in enumerate(zip(env.pattern.x, env.pattern.y, strict=True)):
            x = x0 + env.station.belt_speed * time
            # An arm may be over it.
            hidden = any(min(np.hypot(x - hx, y - hy), abs(x - hx)) < 0.3 for hx, hy in hands)
            if 0.1 < x < env.station.belt_length - 0.1 and not hidden:
                column, row = (round(place) for place in at(x, y))
                row = min(max(row, 0), len(picture) - 1)
                seen = picture[row, column].tolist()
                if item in gone:
                    assert seen != rgb(ITEM)
                elif item not in fetched:
                    assert seen == rgb(ITEM), (item, x, y)
        lifted = max(lifted, len(gone))
        _, _, ended, _, info = env.step(0)
    assert lifted > 5
    # The end is a picture, too.
    assert env.render().shape == picture.shape
    env.close()


def test_a_hand_goes_to_the_item_and_to_the_bin():
    env = environment("rgb_array", patterns="grid:0.3", items=10)
    env.reset(seed=1)
    env.step(0)
    picks, painter = env.picks, env._painter
    robot = painter._robots[picks.robot[0]]

    def hand(time):
        return painter._hand(int(picks.robot[0]), robot, picks, time)

    assert hand(picks.decide[0]) == (pytest.approx(robot["bin"][0]), False)
    assert hand(picks.grasp[0]) == (pytest.approx((picks.x[0], picks.y[0])), True)
    middle, carries = hand((picks.grasp[0] + picks.release[0]) / 2)
    assert carries and middle[0] == pytest.approx((picks.x[0] + robot["bin"][0][0]) / 2)
    assert hand(picks.release[0]) == (pytest.approx(robot["bin"][0]), False)


def test_every_station_can_be_drawn():
    for name in pickline.Station.built_in():
        env = environment("rgb_array", station=name, patterns=[pickline.Pattern([0.0], [0.0], item_class=["pet"])])
        env.reset(seed=1)
        picture = env.render()
        shown = {tuple(colour) for colour in picture.reshape(-1, 3)[::7].tolist()}
        assert {tuple(rgb(PAPER)), tuple(rgb(BELT))} <= shown, name


def test_gymnasium_is_content():
    check_env(environment("rgb_array"))


def test_a_window_follows_the_steps():
    import pygame

    env = environment("human", patterns="grid:0.3", items=5)
    env.reset(seed=1)
    before = pygame.surfarray.array3d(pygame.display.get_surface())
    env.step(0)
    after = pygame.surfarray.array3d(pygame.display.get_surface())
    assert before.shape == after.shape and (before != after).any()
    assert env.render() is None
    env.close()
    assert not pygame.display.get_init()


def test_wrong_use_is_an_exception(monkeypatch):
    env = environment("rgb_array")
    with pytest.raises(gymnasium.error.ResetNeeded, match="call reset"):
        env.render()
    env.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        env.render()
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(ImportError, match="pip install pygame-ce"):
        environment("rgb_array")
