"""The material table: shipped rows, look-ups, the fallback rule, and changes that happen whole or not at all."""

from __future__ import annotations

import doctest
import math
import pickle
import subprocess
import sys
import warnings
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stiction import materials
from stiction.errors import InvalidInputError, MaterialWarning
from stiction.materials import DEFAULT_MATERIAL, PROPERTIES, MaterialTable, PairProperties

LECTURE_ROWS = [  # slide "Some coefficients": static and dynamic friction
    ("wood", "concrete", 0.5, 0.4),
    ("wood", "ice", 0.2, 0.1),
    ("glass", "ice", 0.1, 0.03),
    ("glass", "glass", 0.95, 0.4),
    ("metal", "metal", 0.6, 0.4),
    ("lubricated metal", "metal", 0.1, 0.05),
    ("rubber", "concrete", 1.0, 0.8),
    ("wet rubber", "concrete", 0.7, 0.5),
    ("performance tire", "concrete", 1.5, 1.0),
]


def numbers(properties: PairProperties) -> list[float]:
    """The five numbers in the order of PROPERTIES."""
    return [getattr(properties, name) for name in PROPERTIES]


# -- what ships -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("a", "b", "static", "dynamic"), LECTURE_ROWS)
@pytest.mark.parametrize("table", [MaterialTable.lecture(), MaterialTable.default()], ids=["lecture", "default"])
def test_rows_of_the_slides_value_for_value(
    table: MaterialTable, a: str, b: str, static: float, dynamic: float
) -> None:
    found = table.pair(a, b)
    assert numbers(found) == [static, dynamic, 0.0, 0.0, 0.0]
    assert table.is_set(a, b)
    assert "session 7 'Friction'" in found.source
    assert "'Some coefficients'" in found.source


def test_lecture_holds_its_nine_rows_and_nothing_else() -> None:
    table = MaterialTable.lecture()
    wanted = {tuple(sorted((a, b))) for a, b, _, _ in LECTURE_ROWS} | {(DEFAULT_MATERIAL, DEFAULT_MATERIAL)}
    assert {(a, b) for a, b, _ in table.pairs()} == wanted
    assert len(table) == 10
    assert table.materials == sorted({name for pair in wanted for name in pair})


def test_default_adds_many_sourced_pairs() -> None:
    lecture, table = MaterialTable.lecture(), MaterialTable.default()
    assert len(table) >= len(lecture) + 20
    assert {(a, b) for a, b, _ in lecture.pairs()} < {(a, b) for a, b, _ in table.pairs()}
    assert sum(row.rolling > 0.0 for _, _, row in table.pairs()) >= 5


@pytest.mark.parametrize(("a", "b", "row"), [*MaterialTable.default().pairs()])
def test_every_shipped_row_is_physical_and_says_where_it_is_from(a: str, b: str, row: PairProperties) -> None:
    assert a <= b
    assert 0.0 <= row.dynamic <= row.static <= 2.0
    assert 0.0 <= row.restitution <= 1.0
    assert 0.0 <= row.rolling <= 0.05  # a lever arm above 5 cm would be soft ground, not a pair of solids
    assert 0.0 <= row.torsional <= 0.05
    assert len(row.source) > 20
    assert "fallback" not in row.source
    assert row.source != "set by user"


def test_torsional_lever_arm_of_a_pool_ball_gives_the_spin_deceleration_it_was_taken_from() -> None:
    """A ball spinning on the spot: alpha = torsional m g / (2/5 m R^2) = 10 rad/s^2; rolling ratio delta / R = 0.01."""
    row, radius = MaterialTable.default().pair("billiard ball", "billiard cloth"), 0.028575
    assert row.torsional * 9.81 / (0.4 * radius**2) == pytest.approx(10.0, rel=1e-3)
    assert row.rolling / radius == pytest.approx(0.01)


def test_tables_do_not_share_state() -> None:
    changed = MaterialTable.lecture()
    changed.set_pair("wood", "ice", static=0.9)
    assert MaterialTable.lecture().pair("wood", "ice").static == 0.2
    assert MaterialTable.default().pair("wood", "ice").static == 0.2


def test_importing_the_module_does_not_read_the_data_file() -> None:
    code = (
        "import sys; from stiction.materials import MaterialTable; assert 'tomllib' not in sys.modules;"
        "assert 'pydantic' not in sys.modules; MaterialTable(); assert 'tomllib' not in sys.modules;"
        "MaterialTable.lecture(); assert 'tomllib' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


# -- look up ----------------------------------------------------------------------------------------------------------


def test_an_empty_table_knows_the_default_material_only() -> None:
    table = MaterialTable()
    assert table.materials == ["default"]
    assert "default" in table
    assert "wood" not in table
    assert len(table) == 1
    assert numbers(table.pair("default", "default")) == [0.5, 0.4, 0.0, 0.0, 0.0]


def test_pairs_are_sorted_and_unordered() -> None:
    table = MaterialTable()
    table.set_pair("wood", "ice", static=0.2)
    table.set_pair("brick", "wood", static=0.6)
    assert [(a, b) for a, b, _ in table.pairs()] == [("brick", "wood"), ("default", "default"), ("ice", "wood")]
    assert table.pair("ice", "wood") == table.pair("wood", "ice")


@pytest.mark.parametrize(
    ("wrong", "hint"),
    [("Wood", "'wood'"), ("concret", "'concrete'"), ("rubbr", "'rubber'"), ("preformance tire", "'performance tire'")],
)
def test_an_unknown_material_is_refused_with_the_nearest_known_one(wrong: str, hint: str) -> None:
    table = MaterialTable.lecture()
    sentence = rf"^material must be one of the 10 in the table, got '{wrong}' \(did you mean {hint}\?\)\.$"
    for look_up in (
        lambda: table.pair(wrong, "ice"),
        lambda: table.pair("ice", wrong),
        lambda: table.is_set("ice", wrong),
        lambda: table.to_array(["ice", wrong]),
    ):
        with pytest.raises(InvalidInputError, match=sentence):
            look_up()
    assert wrong not in table


def test_repr_counts() -> None:
    assert repr(MaterialTable.lecture()) == "<MaterialTable: 10 materials, 10 pairs>"


# -- change -----------------------------------------------------------------------------------------------------------


def test_a_new_pair_has_dynamic_as_static_and_nothing_else() -> None:
    table = MaterialTable()
    table.set_pair("a", "b", static=0.7)
    assert table.pair("a", "b") == PairProperties(0.7, 0.7, 0.0, 0.0, 0.0, "set by user")


def test_what_is_not_given_keeps_its_value() -> None:
    table = MaterialTable()
    table.set_pair("a", "b", static=0.7, dynamic=0.6, restitution=0.5, rolling=1e-3, torsional=2e-3, source="lab")
    table.set_pair("b", "a", restitution=0.25)
    assert table.pair("a", "b") == PairProperties(0.7, 0.6, 0.25, 1e-3, 2e-3, "set by user")
    table.set_pair("default", "default", static=0.9)
    assert numbers(table.pair("default", "default")) == [0.9, 0.4, 0.0, 0.0, 0.0]


BAD_CHANGES = [
    ({"static": math.nan}, "static friction of wood - ice must be a finite number, got nan."),
    ({"static": math.inf}, "static friction of wood - ice must be a finite number, got inf."),
    ({"static": -0.1}, "static friction of wood - ice must be 0 or more, got -0.1."),
    ({"static": "0.2"}, "static friction of wood - ice must be a finite number, got '0.2'."),
    ({"static": 0.3, "dynamic": math.nan}, "dynamic friction of wood - ice must be a finite number, got nan."),
    ({"static": 0.3, "dynamic": -1}, "dynamic friction of wood - ice must be 0 or more, got -1."),
    ({"static": 0.3, "restitution": 1.5}, "restitution of wood - ice must be between 0 and 1, got 1.5."),
    ({"static": 0.3, "restitution": -0.5}, "restitution of wood - ice must be between 0 and 1, got -0.5."),
    ({"static": 0.3, "restitution": math.nan}, "restitution of wood - ice must be a finite number, got nan."),
    ({"static": 0.3, "rolling": -1e-3}, "rolling resistance of wood - ice must be 0 m or more, got -0.001."),
    ({"static": 0.3, "torsional": math.inf}, "torsional resistance of wood - ice must be a finite number, got inf."),
    ({"static": 0.3, "source": " "}, "source of wood - ice must be a non-empty text, got ' '."),
]


@pytest.mark.parametrize(("change", "sentence"), BAD_CHANGES)
@pytest.mark.parametrize("known", [True, False], ids=["known pair", "new pair"])
def test_a_refused_change_changes_nothing(change: dict[str, object], sentence: str, known: bool) -> None:
    table = MaterialTable.lecture() if known else MaterialTable()
    before, version = table.copy(), table.version
    with pytest.raises(InvalidInputError) as refusal:
        table.set_pair("wood", "ice", **change)  # type: ignore[arg-type]  # wrong on purpose
    assert str(refusal.value) == sentence
    assert table == before
    assert table.version == version
    assert ("wood" in table) is known


def test_a_new_pair_needs_static_friction() -> None:
    table = MaterialTable()
    with pytest.raises(InvalidInputError, match=r"^static friction of a - b must be given for a new pair, got None\.$"):
        table.set_pair("a", "b", dynamic=0.3)
    assert table == MaterialTable()


@pytest.mark.parametrize("name", ["", " ", " wood", "wood\n", 3, None, ["wood"]])
def test_a_name_is_a_text(name: object) -> None:
    table = MaterialTable.lecture()
    before = table.copy()
    for use in (
        lambda: table.set_pair(name, "ice", static=0.1),  # type: ignore[arg-type]  # wrong on purpose
        lambda: table.set_pair("ice", name, static=0.1),  # type: ignore[arg-type]  # wrong on purpose
        lambda: table.add_material(name),  # type: ignore[arg-type]  # wrong on purpose
        lambda: table.pair("ice", name),  # type: ignore[arg-type]  # wrong on purpose
    ):
        with pytest.raises(InvalidInputError, match="material name must be a non-empty text"):
            use()
    assert table == before


def test_dynamic_above_static_is_set_and_warned_about() -> None:
    table = MaterialTable()
    sentence = r"^dynamic friction of wood - ice should be at most its static friction 0\.2, got 0\.3\.$"
    with pytest.warns(MaterialWarning, match=sentence) as caught:
        table.set_pair("wood", "ice", static=0.2, dynamic=0.3)
    assert caught[0].filename == __file__
    assert table.pair("wood", "ice").dynamic == 0.3
    table.set_pair("wood", "ice", static=0.3)  # equal is fine: the suite turns warnings into errors


def test_version_rises_with_every_change_and_only_then() -> None:
    table = MaterialTable()
    seen = [table.version]
    table.add_material("felt")
    seen.append(table.version)
    table.set_pair("felt", "wood", static=0.4)
    seen.append(table.version)
    table.set_pair("felt", "wood", rolling=1e-3)
    seen.append(table.version)
    assert seen == sorted(set(seen))

    table.add_material("felt")
    table.set_pair("wood", "felt", static=0.4, dynamic=0.4, rolling=1e-3)
    table.pair("wood", "default")
    table.to_array(table.materials)
    assert table.version == seen[-1]


def test_a_copy_is_independent() -> None:
    table = MaterialTable.lecture()
    copied = table.copy()
    assert copied == table
    assert copied.version == table.version
    copied.set_pair("wood", "ice", static=0.3)
    copied.add_material("felt")
    assert copied != table
    assert table == MaterialTable.lecture()
    assert "felt" not in table


def test_equality_sees_materials_values_and_sources() -> None:
    table = MaterialTable.lecture()
    lone = table.copy()
    lone.add_material("felt")
    cited = table.copy()
    cited.set_pair("wood", "ice", source="my notebook")
    assert table != lone
    assert table != cited
    assert table != "MaterialTable"
    assert pickle.loads(pickle.dumps(cited)) == cited


# -- the fallback rule ------------------------------------------------------------------------------------------------


def test_two_self_pairs_combine() -> None:
    """Friction by geometric mean, the rest by the larger."""
    table = MaterialTable()
    table.set_pair("a", "a", static=0.9, dynamic=0.4, restitution=0.8, rolling=1e-3, torsional=0.0)
    table.set_pair("b", "b", static=0.4, dynamic=0.1, restitution=0.2, rolling=2e-3, torsional=3e-3)
    found = table.pair("b", "a")
    assert not table.is_set("a", "b")
    assert numbers(found) == pytest.approx([0.6, 0.2, 0.8, 2e-3, 3e-3])
    assert found.source == "fallback: geometric mean of a (a - a) and b (b - b)"


def test_a_material_without_self_pair_is_the_mean_of_its_pairs() -> None:
    table = MaterialTable.lecture()
    found = table.pair("wood", "glass")
    assert found.static == pytest.approx(math.sqrt((0.5 + 0.2) / 2 * 0.95))
    assert found.dynamic == pytest.approx(math.sqrt((0.4 + 0.1) / 2 * 0.4))
    assert found.source == "fallback: geometric mean of glass (glass - glass) and wood (mean of 2 pairs)"
    assert table.pair("rubber", "metal").source == (
        "fallback: geometric mean of metal (metal - metal) and rubber (concrete - rubber)"
    )


def test_a_material_without_any_pair_is_as_the_default() -> None:
    table = MaterialTable()
    table.add_material("felt")
    assert numbers(table.pair("felt", "felt")) == numbers(table.pair("default", "default"))
    assert table.pair("felt", "felt").source == "fallback: felt (as default)"
    assert numbers(table.pair("felt", "default")) == numbers(table.pair("default", "default"))
    table.set_pair("default", "default", static=0.8, dynamic=0.7)
    assert table.pair("felt", "felt").static == 0.8


def test_a_material_against_itself_is_its_own_mean() -> None:
    table = MaterialTable.lecture()
    found = table.pair("ice", "ice")
    assert found.static == pytest.approx(0.15)
    assert found.dynamic == pytest.approx(0.065)
    assert found.source == "fallback: ice (mean of 2 pairs)"


def test_a_frictionless_surface_stays_frictionless() -> None:
    table = MaterialTable.lecture()
    table.set_pair("air bearing", "air bearing", static=0.0)
    assert numbers(table.pair("air bearing", "rubber"))[:2] == [0.0, 0.0]


def test_a_guess_follows_later_changes() -> None:
    table = MaterialTable.lecture()
    table.pair("wood", "glass")
    table.set_pair("wood", "wood", static=0.38, dynamic=0.38)
    assert table.pair("wood", "glass").static == pytest.approx(math.sqrt(0.38 * 0.95))
    table.set_pair("wood", "glass", static=0.11)
    assert table.pair("wood", "glass").static == 0.11


NAMES = ["default", "a", "b", "c", "d"]
# The largest float shows that no mean or product overflows; the smallest ones would only show their own lost digits.
coefficient = st.one_of(
    st.floats(0.0, 3.0, allow_subnormal=False), st.sampled_from([0.0, 1e-200, 1e200, sys.float_info.max])
)
length = st.floats(0.0, 0.1)


@st.composite
def tables(draw: st.DrawFn) -> MaterialTable:
    """A table with random pairs of a few materials; dynamic friction may be set above static, as users can."""
    table = MaterialTable()
    for name in NAMES:
        table.add_material(name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MaterialWarning)
        for _ in range(draw(st.integers(0, 8))):
            table.set_pair(
                draw(st.sampled_from(NAMES)),
                draw(st.sampled_from(NAMES)),
                static=draw(coefficient),
                dynamic=draw(coefficient),
                restitution=draw(st.floats(0.0, 1.0)),
                rolling=draw(length),
                torsional=draw(length),
            )
    return table


def expected_own(table: MaterialTable, name: str) -> np.ndarray:
    """Step 1 of the rule, written a second time, in exact fractions."""
    chosen = [numbers(row) for a, b, row in table.pairs() if (a, b) == (name, name)]
    chosen = chosen or [numbers(row) for a, b, row in table.pairs() if name in (a, b)]
    chosen = chosen or [numbers(table.pair("default", "default"))]
    return np.array([float(sum(map(Fraction, column)) / len(chosen)) for column in zip(*chosen, strict=True)])


@given(tables())
def test_fallback_rule_over_random_tables(table: MaterialTable) -> None:
    for a in NAMES:
        for b in NAMES:
            found = table.pair(a, b)
            assert found == table.pair(b, a)
            if table.is_set(a, b):
                continue
            own_a, own_b = expected_own(table, a), expected_own(table, b)
            friction = np.sqrt(own_a[:2]) * np.sqrt(own_b[:2])
            friction[1] = min(friction)
            assert numbers(found) == pytest.approx(
                [*friction, *np.maximum(own_a[2:], own_b[2:])], rel=1e-12, abs=1e-300
            )
            assert found.dynamic <= found.static
            assert found.static * (1 - 1e-12) <= max(own_a[0], own_b[0])
            assert 0.0 <= found.restitution <= 1.0
            assert found.source.startswith("fallback: ")


# -- arrays and rows --------------------------------------------------------------------------------------------------


@given(tables(), st.lists(st.sampled_from(NAMES), max_size=5))
def test_to_array_is_pair_for_pair(table: MaterialTable, names: list[str]) -> None:
    array = table.to_array(names)
    assert array.shape == (len(names), len(names), 5)
    assert array.dtype == np.float64
    for i, a in enumerate(names):
        for j, b in enumerate(names):
            assert array[i, j].tolist() == numbers(table.pair(a, b))


@given(tables())
def test_rows_round_trip(table: MaterialTable) -> None:
    rows = table.to_toml_rows()
    assert all(isinstance(value, str | float) for row in rows for value in row.values())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MaterialWarning)
        assert MaterialTable.from_rows(rows) == table


def test_shipped_tables_round_trip() -> None:
    for table in (MaterialTable.lecture(), MaterialTable.default()):
        assert MaterialTable.from_rows(table.to_toml_rows()) == table


def test_rows_may_leave_out_what_set_pair_may() -> None:
    table = MaterialTable.from_rows([{"a": "wood", "b": "ice", "static": 0.2}, {"material": "felt"}])
    assert table.pair("ice", "wood") == PairProperties(0.2, 0.2, 0.0, 0.0, 0.0, "set by user")
    assert table.materials == ["default", "felt", "ice", "wood"]


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([{"a": "wood", "static": 0.2}], "materials row 1 must name two materials a and b"),
        ([{"a": "x", "b": "y", "static": 1.0}, {"b": "y"}], "materials row 2 must name two materials a and b"),
        ([{"a": "x", "b": "y", "statik": 1.0}], r"key of materials row 1 .* got 'statik' \(did you mean 'static'\?\)"),
        ([{"material": "x", "static": 1.0}], "key of materials row 1 must be one of material, got 'static'"),
        ([{"a": "x", "b": "y", "static": -1.0}], "static friction of x - y must be 0 or more, got -1.0"),
        ([{"a": "x", "b": 2, "static": 1.0}], "material name must be a non-empty text .* got 2"),
        (["wood"], "materials row 1 must be a table of keys and values, got 'wood'"),
        (
            [{"a": "x", "b": "y", "static": 1.0}, {"a": "y", "b": "x", "static": 2.0}],
            "materials row 2 must not set y - x again",
        ),
    ],
)
def test_bad_rows_are_refused(rows: list[dict[str, object]], sentence: str) -> None:
    with pytest.raises(InvalidInputError, match=sentence):
        MaterialTable.from_rows(rows)


# -- documentation ----------------------------------------------------------------------------------------------------


def test_examples_in_the_page_and_in_the_docstrings_are_true() -> None:
    page = Path(__file__).parents[1] / "docs" / "materials.md"
    in_page = doctest.testfile(str(page), module_relative=False, encoding="utf-8")
    in_module = doctest.testmod(materials)
    assert in_page.failed == in_module.failed == 0
    assert in_page.attempted >= 10
    assert in_module.attempted >= 4
