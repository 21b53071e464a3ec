"""A study of a small world, whose films need no search."""

TINY = """
study
    title = "Help or hinder"
    seeds = "0-3"

condition help
    label = "helping"
    story = "help.story"
    right = helping
condition hinder
    story = "hinder.story"
    right = hindering

method naive
    naive = yes
method short
    naive = yes
    set = ["length = 2"]
    against = naive

question
    ask = "What was the robot doing?"
answer helping
    event = "rho > 0"
answer hindering
    event = "rho < 0"
answer unclear

people help
    naive = 0.5

panel viewers
    viewers = 6
    sharpness = (0.3, 2)
    forgetting = {0.001, 0.1}
    doubt = 0.5
    rule = {maximum, matching}
    confidence = (0.3, 0.8)
    lapse = (0, 0.1)
panel own
    viewers = 1
"""
