"""The reference itself, against what can be worked out by hand."""

import math

import pytest

import reference as ref
from reference import Character, Object, World

G = 0.9  # gamma of the closed forms
STAY = math.exp(1.8) / (math.exp(1.8) + 4)  # softmax(2 Q)[stay], if a move costs 0.9 more


def close(x):
    return pytest.approx(x, abs=1e-8)


def alone(rows=(".",), home=(0, 0), goals=("home", "none"), success=1.0, **settings):
    return World(rows, {"home": home}, [Character("a", success, (), goals)], gamma=G, **settings)


def corridor(goal, success=0.0, weak_robot=1.0, **settings):
    """1 x 3: the cheese, which wants `goal`, cannot move by itself; the robot pushes it."""
    pair = [
        Character("cheese", success, (), ("home",)),
        Character("robot", weak_robot, ("cheese",), ("none",), "cheese", (-3, 0, 3)),
    ]
    return World(["..."], {"home": goal}, pair, gamma=G, **settings)


def both(rho, cheese="home", robot="none"):
    return {"G_cheese": cheese, "G_robot": robot, "rho": rho, "R_cheese": True, "R_robot": True}


@pytest.fixture(scope="module")
def small():
    return ref.kitchen(["P..", "..G"], gamma=G)


def told(world, start, *turns):
    script = ref.new_script(world, world.state(start))
    for actions in turns:
        state = world.state_at(script, len(script["frames"]))
        script = ref.append(script, ref.turn(world, state, actions))
    return script


START = {"cheese": [1, 0], "robot": [0, 1], "table": None}


@pytest.fixture(scope="module")
def story(small):
    """The cheese moves and fails; the robot walks under it and lifts nothing."""
    return told(
        small,
        START,
        {"cheese": "east", "robot": "east"},
        {"cheese": "south!", "robot": "east"},
        {"cheese": "west", "robot": "stay"},
    )


# ---- Counting


def test_hypotheses_of_the_kitchen():
    merged, literal = ref.kitchen().hypotheses, ref.kitchen(hypotheses="literal").hypotheses
    assert (len(merged), len(literal)) == (34, 72)
    assert sum(map(ref.rational, merged)) == 28
    assert sum(map(ref.rational, literal)) == 30
    assert merged.count({"R_cheese": False, "R_robot": False}) == 1
    assert literal.count({"R_cheese": False, "R_robot": False}) == 6
    assert literal.count({"G_cheese": "pink", "R_cheese": True, "R_robot": False}) == 15
    beside = [h for h in merged if not h["R_cheese"] and h["R_robot"]]
    assert [(h["G_robot"], h["rho"]) for h in beside] == [("pink", 0), ("green", 0), ("none", 0)]
    assert all("G_cheese" not in h for h in beside)


def test_prior_of_helping():
    for reading, p in (("merged", 12 / 28), ("literal", 12 / 30)):
        world = ref.kitchen(hypotheses=reading)
        script = ref.new_script(world, {"cheese": [1, 1], "robot": [3, 1], "table": None})
        assert ref.P(world, script, 0, ref.HELPS) == close(p)
    assert ref.P(world, script, 0, ref.HELPS, assume=None) == close(12 / 72)


def test_hypotheses_of_other_worlds():
    assert alone().hypotheses == [
        {"G_a": "home", "R_a": True},
        {"G_a": "none", "R_a": True},
        {"R_a": False},
    ]
    pair = [Character("a", goals=("x", "y")), Character("b", goals=("x", "none"), models="a")]
    world = World(["..."], {"x": (0, 0), "y": (1, 0)}, pair)
    assert len(world.hypotheses) == 4 + 2 + 2 + 1  # no rho: a rational one without a goal counts
    assert not any("rho" in h for h in world.hypotheses)


def test_number_of_states():
    assert len(ref.kitchen().free) == 60
    assert ref.kitchen().count_states() == 60 * 59 * 58 + 60 * 59 == 208_860
    world = ref.kitchen(["P#.", "..G"])
    states = [s for present in world.presences() for s in world.states(present)]
    assert len(states) == len(set(states)) == world.count_states() == 5 * 4 * 3 + 5 * 4


# ---- Moves


def test_walking_and_pushing():
    world = ref.kitchen(["P..", ".#G", "..."])
    s = world.state({"cheese": (1, 0), "robot": (0, 0), "table": (2, 2)})
    for action in ("north", "south", "west", "stay"):  # edge, wall, robot
        assert world.effect(s, "cheese", action) == s
    assert world.effect(s, "cheese", "east") == ((2, 0), (0, 0), (2, 2))
    assert world.outcomes(s, "cheese", "east") == [(0.6, ((2, 0), *s[1:])), (0.4, s)]
    assert world.outcomes(s, "cheese", "west") == [(1.0, s)]
    pushed = world.effect(s, "robot", "east")
    assert pushed == ((2, 0), (1, 0), (2, 2))
    assert world.effect(pushed, "robot", "east") == pushed  # at the edge
    s = world.state({"cheese": (2, 1), "robot": (2, 0), "table": (2, 2)})
    assert world.effect(s, "robot", "south") == s  # not two things at once
    s = world.state({"cheese": (2, 1), "robot": (2, 0), "table": None})
    assert world.effect(s, "robot", "south") == ((2, 2), (2, 1), None)


def test_number_of_children():
    world = ref.kitchen(["P....", ".....", ".....", "....G", "....."])
    apart = {"cheese": (1, 1), "robot": (3, 3), "table": None}
    assert len(ref.children(world, apart)) == (1 + 4 * 2) * 5
    assert len(ref.children(world, apart, allow=["table"])) == 45 + 23
    assert len(ref.children(world, {**apart, "table": (0, 0)}, allow=["table"])) == 45
    # in a corner the cheese has two moves that can fail, two that are blocked, and the stay
    assert len(ref.children(world, {**apart, "cheese": (0, 0)})) == (2 * 2 + 2 + 1) * 5


# ---- Values


def test_a_cell_of_its_own():
    world, s = alone(), ((0, 0),)
    home, none = world.hypotheses[:2]
    assert world.value("a", home, s) == close(0.9 / (1 - G))
    assert world.value("a", none, s) == close(-0.1 / (1 - G))
    assert world.q_values("a", home, s)["north"] == close(0 + G * 0.9 / (1 - G))
    assert world.policy("a", home, s) == close(
        {**dict.fromkeys(ref.MOVES, (1 - STAY) / 4), "stay": STAY}
    )


@pytest.mark.parametrize("p", [0.6, 1.0])
def test_two_cells_and_a_weak_character(p):
    world = alone([".."], home=(1, 0), success=p)
    home, goal = world.hypotheses[0], 0.9 / (1 - G)
    assert world.value("a", home, ((1, 0),)) == close(goal)
    away = (-1 + G * p * goal) / (1 - G * (1 - p))
    assert world.value("a", home, ((0, 0),)) == close(away)
    assert world.q_values("a", home, ((0, 0),))["stay"] == close(-0.1 + G * away)


@pytest.mark.parametrize(
    ("level0", "p"),
    [("uniform", 1 / 5), ("costs", math.exp(-2) / (4 * math.exp(-2) + math.exp(-0.2)))],
)
def test_cheese_fears_a_careless_robot(level0, p):
    """Robot at 0, cheese on its goal at 1: with p the robot pushes it off, for ever."""
    world = corridor((1, 0), level0=level0)
    lost = -0.1 / (1 - G)
    on = (0.9 + G * p * lost) / (1 - G * (1 - p))
    state = {"cheese": (1, 0), "robot": (0, 0)}
    for h in (both(3), both(-3), {"G_cheese": "home", "R_cheese": True, "R_robot": False}):
        assert world.value("cheese", h, state) == close(on)


@pytest.mark.parametrize("p", [1.0, 0.5])
@pytest.mark.parametrize("first", ["cheese", "robot"])
def test_a_robot_pushes_the_cheese_to_its_goal(p, first):
    """Robot at 0, cheese at 1, goal at 2, rho = 3; a weak robot tries until it succeeds."""
    world = corridor((2, 0), weak_robot=p)
    if first == "robot":
        pair = list(world.characters.values())[::-1]
        world = World(["..."], {"home": (2, 0)}, pair, gamma=G)
    away = -0.1 * STAY - (1 - STAY)  # the cheese's expected reward, off its goal
    done = (-0.1 + G * 3 * (1 + away)) / (1 - G)
    before = (-1 + G * (p * (3 * (1 + away) + done) + (1 - p) * 3 * away)) / (1 - G * (1 - p))
    at_goal, at_start = {"cheese": (2, 0), "robot": (1, 0)}, {"cheese": (1, 0), "robot": (0, 0)}
    assert world.value("robot", both(3), at_goal) == close(done)
    assert world.value("robot", both(3), at_start) == close(before)
    q = world.q_values("robot", both(3), at_start)
    assert q["stay"] == close(-0.1 + G * (3 * away + before))
    idle = -0.1 / (1 - G)  # rho = 0, or hindering a cheese that is off its goal: it just stays
    assert world.value("robot", both(0), at_start) == close(idle)
    hinder = (-0.1 - G * 3 * away) / (1 - G)
    assert world.value("robot", both(-3), at_start) == close(hinder)


def test_values_solve_their_equation(small):
    """max_a Q = V where Q is one backup, at level 1, level 2, and beside a random cheese."""
    alone_rational = {"G_robot": "pink", "rho": 0, "R_cheese": False, "R_robot": True}
    for who, h in [
        ("cheese", both(-3, "pink", "green")),
        ("robot", both(-3, "pink", "green")),
        ("robot", alone_rational),
    ]:
        for s in small.states(small.entities):
            v = small.value(who, h, s)
            assert max(small.q_values(who, h, s).values()) == close(v)


def test_a_modeller_without_attitude_is_an_indifferent_one():
    rows = ["P..", "..G"]
    plain = {"toward": None, "attitude": ()}
    judged = ref.kitchen(rows, table=False, gamma=G)
    models = ref.kitchen(rows, table=False, gamma=G, robot={**plain, "models": "cheese"})
    naive = ref.kitchen(rows, table=False, gamma=G, robot=plain)
    h = both(0, "green", "pink")
    random = {**h, "R_cheese": False}  # level 0 plays uniformly: as beside an irrational one
    differ = 0.0
    for s in judged.states(judged.entities):
        assert models.value("robot", h, s) == close(judged.value("robot", h, s))
        assert naive.value("robot", h, s) == close(judged.value("robot", random, s))
        differ = max(differ, abs(naive.value("robot", h, s) - models.value("robot", h, s)))
    assert differ > 0.01


def test_mirroring_the_map_changes_nothing():
    east = {"north": "north", "south": "south", "east": "west", "west": "east", "stay": "stay"}
    left = ref.kitchen(["P..", "..G"], table=False, gamma=G)
    right = ref.kitchen(["..P", "G.."], table=False, gamma=G)
    h = both(1, "green", "pink")
    for s in left.states(left.entities):
        q = left.q_values("robot", h, s)
        mirrored = right.q_values("robot", h, tuple((2 - x, y) for x, y in s))
        assert {a: mirrored[b] for a, b in east.items()} == close(q)


# ---- The audience


def test_one_update_by_hand():
    world = alone(forgetting=0.01)
    script = told(world, {"a": [0, 0]}, {"a": "stay"})
    p = STAY / (2 * STAY + 0.2)
    forgotten = p * 0.99 + (1 - p) / 2 * 0.01
    belief = world.beliefs(script)[1]
    assert belief == close({0: forgotten, 1: forgotten, 2: 1 - 2 * forgotten})
    assert ref.P(world, script, 1, ref.rational, assume=None) == close(2 * forgotten)
    assert ref.surprise(world, script, 1) == close(-math.log(STAY))
    assert ref.surprise(world, script, 1, assume=None) == close(-math.log((2 * STAY + 0.2) / 3))
    assert ref.entropy(world, script, 0) == close(math.log(2))
    assert ref.entropy(world, script, 0, assume=None) == close(math.log(3))
    assert ref.entropy(world, script, 1, "G_a") == close(math.log(2))
    third, b = 1 / 3, forgotten
    kl = 2 * third * math.log(third / b) + third * math.log(third / (1 - 2 * b))
    assert ref.KL(world, script, 0, 1, assume=None) == close(kl)
    assert ref.KL(world, script, 0, 1) == close(0)
    assert ref.EV(world, script, 0, "a") == close(0.4 / (1 - G))
    assert ref.EV(world, script, 1, "a", assume=None) == close(0.4 / (1 - G))
    # suspense about R: it is 2 Var of P(R), over staying and moving (every move is blocked)
    stay = (2 * STAY + 0.2) / 3
    move = 1 - stay
    moving = 2 * (1 - STAY) / 3 / move
    moving = moving * 0.99 + (2 - moving) / 2 * 0.01
    assert ref.suspense(world, ref.prefix(script, 0), 0, "R_a", assume=None) == close(
        2 * stay * move * (2 * forgotten - moving) ** 2
    )
    assert ref.suspense(world, ref.prefix(script, 0), 0, "G_a") == close(0)


def test_beliefs_are_distributions(small, story):
    steps = small.beliefs(story)
    assert len(steps) == 4
    assert steps[0] == dict.fromkeys(range(34), 1 / 34)
    for belief in steps:
        assert math.isclose(sum(belief.values()), 1)
        assert min(belief.values()) >= 1e-5 / 33
    seen = small.beliefs_before(story, 2)
    assert [(who, action) for who, action, _, _ in seen] == [("cheese", "south"), ("robot", "east")]
    assert seen[0][3] == steps[1]
    assert small.update(seen[1][3], "robot", seen[1][2], "east") == steps[2]


def test_queries_hang_together(small, story):
    for assume in (ref.rational, None):
        signs = [ref.P(small, story, 2, ref.rho_is(i), assume=assume) for i in (-1, 0, 1)]
        unknown = ref.P(small, story, 2, lambda h: "rho" not in h, assume=assume)
        assert sum(signs) + unknown == close(1)
        assert ref.suspense(small, story, 1, "rho", assume=assume) > 0
    chances = [
        math.exp(-ref.surprise(small, ref.append(ref.prefix(story, 1), frame), 2))
        * ref.chance(small, small.state_at(story, 1), frame)
        for frame in ref.children(small, small.state_at(story, 1))
    ]
    assert sum(chances) == close(1)
    helps_pink = ref.P(small, story, 3, ref.HELPS, [ref.PINK]) * ref.P(small, story, 3, ref.PINK)
    assert helps_pink == close(ref.P(small, story, 3, lambda h: ref.HELPS(h) and ref.PINK(h)))
    mean_rho = sum(v * ref.P(small, story, 3, ref.latent_is("rho", v)) for v in (-3, -1, 0, 1, 3))
    assert ref.E(small, story, 3, lambda h: h.get("rho")) == close(mean_rho)
    assert ref.KL(small, story, 1, 2) >= ref.KL(small, story, 1, 2, "rho") >= 0


def test_the_second_one_acts_where_the_first_went(small):
    """The robot's action is judged in the state that the cheese's move made."""
    start = {"cheese": [1, 0], "robot": [1, 1], "table": None}
    went, stayed = (told(small, start, {"cheese": c, "robot": "north"}) for c in ("west", "west!"))
    assert small.beliefs_before(went, 1)[1][2] == ((0, 0), (1, 1), None)
    assert small.beliefs_before(stayed, 1)[1][2] == ((1, 0), (1, 1), None)
    assert small.beliefs(went)[1] != small.beliefs(stayed)[1]


def test_an_event_updates_nothing(small, story):
    state = small.state_at(story, 3)
    fallen = ref.append(story, ref.deus(small, state, "table", (1, 1)))
    assert small.beliefs(fallen)[4] == small.beliefs(fallen)[3]
    assert small.state_at(fallen, 4) == (*state[:2], (1, 1))
    assert ref.surprise(small, fallen, 4) == 0
    assert ref.KL(small, fallen, 3, 4) == 0
    assert ref.fell(small, fallen, 4, "table")
    assert not ref.fell(small, fallen, 3, "table")
    assert not ref.tried(small, fallen, 4, "robot")
    assert not ref.moved(small, fallen, 4, "table")
    assert ref.EV(small, fallen, 4, "robot") != ref.EV(small, fallen, 3, "robot")


# ---- Predicates and stories


def test_predicates(small):
    script = told(
        small,
        {"cheese": [1, 0], "robot": [0, 0], "table": None},
        {"cheese": "north", "robot": "east"},
        {"cheese": "west!", "robot": "stay"},
    )
    first, second = small.state_at(script, 1), small.state_at(script, 2)
    assert ref.pushes(small, script, 1, "robot", "cheese")
    assert not ref.pushes(small, script, 2, "robot", "cheese")
    assert ref.moved(small, script, 1, "robot")
    assert not ref.moved(small, script, 1, "cheese")  # being pushed does not count
    assert ref.tried(small, script, 1, "cheese")
    assert ref.tried(small, script, 2, "cheese")
    assert not ref.tried(small, script, 2, "robot")
    assert first == second == ((2, 0), (1, 0), None)
    assert ref.adjacent(small, first, "robot", "cheese")
    assert not ref.adjacent(small, first, "robot", "table")
    assert ref.absent(small, first, "table")
    assert ref.at(small, first, "cheese", (2, 0))
    assert not ref.at(small, first, "cheese", "green")
    assert ref.at(small, {**START, "robot": [2, 1]}, "robot", "green")


def test_plausibility_counts_what_could_succeed(small, story):
    # east succeeds, south fails though it could (the robot is at (1, 1)), west succeeds
    counts = [ref.plausibility(small, ref.prefix(story, n)) for n in range(4)]
    assert counts == close([0, -(0.4**2), -(0.1**2), -((2 / 3 - 0.6) ** 2)])
    blocked = told(small, START, {"cheese": "north", "robot": "stay"})
    assert ref.plausibility(small, blocked) == 0


def test_stories_by_hand(small, story):
    helps = [ref.P(small, story, t, ref.HELPS) for t in (1, 2, 3)]
    value = {name: ref.STORIES[name](small, story, 4) for name in ref.STORIES}
    assert value["help"] == close(sum(helps))
    assert value["help"] + value["hinder"] + value["indifferent"] == close(3)
    known = [ref.P(small, story, t, ref.HELPS, [ref.PINK]) for t in (1, 2)]
    known.append(ref.P(small, story, 3, ref.HINDERS, [ref.PINK]))
    near = [ref.adjacent(small, small.state_at(story, t), "robot", "cheese") for t in (1, 2, 3)]
    moved = ref.moved_others(small, story, 2, {"rho"})
    meetings = (near[0] or near[1]) + near[2]
    assert value["betrayal"] == close(sum(known) + meetings - 0.5 * moved)
    assert moved > 0
    assert value["irony"] <= 9
    calm = ref.arc(small, story, 4, steady=0)
    kl = sum(ref.KL(small, story, t - 1, t) for t in (1, 2, 3))
    assert ref.arc(small, story, 4) == close(calm - 0.1 * kl)
    assert value["arc"] == close(5 * calm - 0.1 * kl)
    sines = [0.7071067811865476, -1, 0.7071067811865476]  # of 3 pi t / 4
    values = [ref.EV(small, story, t, "robot") for t in (1, 2, 3)]
    assert calm == close(0.02 * sum(s * v for s, v in zip(sines, values, strict=True)))
    total = ref.objective("help", 4)(small, story)
    automatic = sum(weight * term(small, story) for weight, term in ref.AUTOMATIC.values())
    assert total == close(value["help"] + automatic)


def test_flashback_shows_one_frame_more(small):
    near = told(small, {"cheese": [1, 0], "robot": [0, 0], "table": None})
    shown = told(small, near["start"], {"cheese": "stay", "robot": "east"})
    for event, name in ((ref.HELPS, "flashback-help"), (ref.HINDERS, "flashback-hinder")):
        p = ref.P(small, shown, 1, event)
        assert ref.STORIES[name](small, near, 3) == close(p + 1)
    far = told(small, START)
    assert ref.STORIES["flashback-help"](small, far, 3) < 1


# ---- Search


def test_a_full_beam_is_exhaustive():
    world = World(
        ["...."],
        {"x": (0, 0), "y": (3, 0)},
        [
            Character("cheese", 0.6, (), ("x", "y")),
            Character("robot", 1.0, ("cheese",), ("x", "y", "none"), "cheese", (-1, 0, 1)),
        ],
        [Object("table", may_be_absent=True)],
        gamma=G,
    )
    start, score = {"cheese": (1, 0), "robot": (2, 0), "table": None}, ref.objective("hinder", 2)
    best, script = ref.exhaustive(world, start, 2, score, ["table"])
    assert len(script["frames"]) == 2
    assert score(world, script) == best
    widths = [ref.beam(world, [start], 2, score, w, ["table"])[0] for w in (1, 10_000)]
    assert widths[0] <= widths[1] == best
    others = [start, {**start, "robot": (3, 0)}]
    assert ref.beam(world, others, 2, score, 1, ["table"])[0] >= widths[0]
