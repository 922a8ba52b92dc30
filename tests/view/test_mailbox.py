"""The mailbox: what waits, what is replaced, and that it stays small."""

from __future__ import annotations

from stiction.view.mailbox import MOST, Mailbox


def test_a_newer_action_takes_the_place_of_an_older_one() -> None:
    box, done = Mailbox(), []
    for k in range(1000):
        assert box.put("slider", lambda k=k: done.append(k))  # type: ignore[misc]  # the default binds k
    assert len(box) == 1
    for action in box.take():
        action()
    assert done == [999]
    assert box.take() == []


def test_actions_come_in_the_order_of_their_last_word() -> None:
    box, done = Mailbox(), []
    for key in ("a", "b", "a"):
        box.put(key, lambda key=key: done.append(key))  # type: ignore[misc]  # the default binds the key
    for action in box.take():
        action()
    assert done == ["b", "a"]


def test_a_flooded_box_does_not_grow() -> None:
    box = Mailbox()
    taken = [box.put(str(k), lambda: None) for k in range(10 * MOST)]
    assert sum(taken) == len(box) == MOST
