"""What stories in planes begin as."""

from __future__ import annotations

from importlib.resources import files

from i2pdsl.worlds.beginnings import Beginning, Beginnings

_TOGETHER = (
    "The two shall be near each other. The number says how much that counts.",
    "minimize sum_t 0.3 * [distance({helped}, {helper}) @ script[t]]",
)
_CALM = (
    "Calm motion: no sudden turns.",
    "minimize sum_t 0.05 * ([acceleration({helped}) @ script[t]] "
    "+ [acceleration({helper}) @ script[t]])",
)
_CALM_ALONE = ("Calm motion: no sudden turns.",
               "minimize sum_t 0.05 * [acceleration({actor}) @ script[t]]")  # fmt: skip
_STRIVES = "0.25 * [heads({helped}, {goal}) @ script[t]]"
_NO_NEARER = "3 * [progress({helped}, {goal}) @ script[t]]"

_WAYS = (
    Beginning(
        "help", "{helper} pushes {helped} to {goal}", "depict", 100,
        (("After every frame viewers shall believe that {helper} helps.",
          "maximize depict({rho} > 0)"),
         ("In the end {helped} shall be there.",
          "maximize 20 * [at({helped}, {goal}) @ script[T]]"), _TOGETHER, _CALM),
    ),
    Beginning(
        "hinder", "{helped} wants to go to {goal}, and {helper} keeps it away", "depict",
        100,
        (("After every frame viewers shall believe that {helper} hinders, and what {helped} wants.",
          "maximize depict({rho} < 0 and G_{helped} = {goal})"),
         ("It shall not come nearer.", f"minimize sum_t {_NO_NEARER}"),
         ("But it shall strive to.", f"maximize sum_t {_STRIVES}"),
         _TOGETHER, _CALM),
    ),
    Beginning(
        "betrayal", "{helper} seems to help {helped} to {goal}, and turns against it", "twist", 140,
        (("In the first half viewers shall believe that {helper} helps, in the second that it "
          "hinders; and all along that {helped} wants {goal}.",
          "maximize twist({rho} > 0 and G_{helped} = {goal}, {rho} < 0 and G_{helped} = {goal})"),
         ("After the turn {helped} shall come no nearer.",
          f"minimize sum_{{{{t in T/2..T}}}} {_NO_NEARER}"),
         ("But it shall strive to.", f"maximize sum_{{{{t in T/2..T}}}} {_STRIVES}"),
         _TOGETHER, _CALM),
    ),
    Beginning(
        "legible", "{actor} goes to {here}, and everybody sees early that it will", "legible", 60,
        (("The earlier viewers know that {actor} wants {here}, the better.",
          "maximize legible(G_{actor} = {here})"),
         ("In the end it shall be there.", "maximize 10 * [at({actor}, {here}) @ script[T]]"),
         _CALM_ALONE),
    ),
    Beginning(
        "deceptive", "{actor} seems to go to {there}, and ends at {here}: a feint", "deceptive", 64,
        (("Viewers shall believe that {actor} wants {there}, while it gets what it wants. `scale`: "
          "how much that counts.",
          "maximize deceptive({actor}, G_{actor} = {here}, G_{actor} = {there}, scale = 3)"),),
    ),
)  # fmt: skip

_MORE = (
    ("the first picture", "start at({helped}, {other})"),
    ("viewers who forget", "audience bayesian(forgetting = 0.05)"),
)

BEGINNINGS = Beginnings(
    "plane", _WAYS, _MORE, template=files("i2pdsl.worlds.plane") / "first.world"
)
