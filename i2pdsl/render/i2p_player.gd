# Plays a story of i2pdsl in Godot 4: on maps, in planes and on the hill.
#
# Put the files that came with it (timeline.json; but for the hill also sprites.json, sprites.png
# and background.png) into one folder of the project, attach this script to a Node2D, and set
# `folder`. Files of JSON are exported with a game only if the export preset names them
# (Resources, "*.json").
#
# `frame_changed` tells each frame as it begins, with what everybody did and what viewers believe.
extends Node2D

signal frame_changed(number: int, frame: Dictionary)
signal finished

@export_dir var folder: String = "res://"
@export var speed: float = 1.0
@export var playing: bool = true
@export var show_background: bool = true
# Of the hill: pixels of a unit, and whether the hopper stays in its place and the slope moves.
@export var unit: float = 16.0
@export var follow: bool = true

var timeline: Dictionary = {}
var sheet: Dictionary = {}
var clock: float = 0.0

var _texture: Texture2D
var _actors: Dictionary = {}
var _marks: Array[Sprite2D] = []
var _frame: int = -1
var _time: float = 0.0


func _ready() -> void:
	timeline = _read(folder.path_join("timeline.json"), "i2p-timeline")
	if timeline.has("shapes"):  # bodies that bend are drawn, and have no sprites
		_draw_at(0.0)
		return
	sheet = _read(folder.path_join("sprites.json"), "i2p-sprites")
	if timeline.is_empty() or sheet.is_empty():
		set_process(false)
		return
	_texture = load(folder.path_join(sheet["image"]))
	if show_background:
		_add_background(sheet["background"])
	for entity in timeline["entities"]:
		_actors[entity["name"]] = _add_sprite("foot")
	for mark in timeline["marks"]:
		var sprite := _add_sprite("middle")
		sprite.z_index = 1
		_show(sprite, sheet["marks"][mark["mark"]])
		_marks.append(sprite)
	_draw_at(0.0)


func _process(delta: float) -> void:
	if not playing:
		return
	clock += delta * speed
	_draw_at(clock)
	var last: Dictionary = timeline["frames"][-1]
	if clock >= last["start"] + last["seconds"] + last["rests"]:
		playing = false
		finished.emit()


# Seconds from the start, as the film has them.
func seek(seconds: float) -> void:
	clock = maxf(seconds, 0.0)
	_frame = -1
	_draw_at(clock)


func _draw_at(seconds: float) -> void:
	var number := _frame_at(seconds)
	if number != _frame:
		_frame = number
		frame_changed.emit(number, timeline["frames"][number])
	var time := _turn_at(seconds)
	_time = time
	queue_redraw()
	for name in _actors:
		var key := _sample(timeline["tracks"][name], time)
		_show(_actors[name], sheet["entities"][name][key["pose"]])
		_place(_actors[name], key, sheet["stands"])
	for i in _marks.size():
		var track: Array = timeline["marks"][i]["keys"]
		_marks[i].visible = track[0][0] < time and time < track[-1][0]
		if _marks[i].visible:
			_place(_marks[i], _sample(track, time), [0.5, 0.5])


# The bodies of the hill bend, and are drawn through their nodes.
func _draw() -> void:
	if not timeline.has("shapes"):
		return
	var from := Vector2.ZERO
	if follow:
		from = _node(timeline["shapes"][-1]["nodes"][0]) * Vector2(1.0, 0.0)
		from.y = -from.x * timeline["world"]["rise"]
	if show_background:
		var far := Vector2(1.0, -timeline["world"]["rise"]) * 100.0 * unit
		draw_line(-far, far, Color(0.58, 0.66, 0.42), 0.5 * unit)
	for shape in timeline["shapes"]:
		var points := PackedVector2Array()
		for node in shape["nodes"]:
			points.append((_node(node) - from) * unit)
		if shape["closed"]:
			draw_colored_polygon(points, Color(shape["color"]))
			points.append(points[0])
		draw_polyline(points, Color(shape["edge"]), shape["width"] * unit)


func _node(node: int) -> Vector2:
	var nodes: Array = timeline["nodes"]
	var before := clampi(floori(_time), 0, nodes.size() - 1)
	var after := mini(before + 1, nodes.size() - 1)
	var a: Array = nodes[before][node]
	var b: Array = nodes[after][node]
	return Vector2(a[0], a[1]).lerp(Vector2(b[0], b[1]), _time - before)


func _frame_at(seconds: float) -> int:
	var frames: Array = timeline["frames"]
	var number := 0
	while number + 1 < frames.size() and frames[number + 1]["start"] <= seconds:
		number += 1
	return number


# Time in turns: frame t of the story spans the times t - 1 to t, and then may rest.
func _turn_at(seconds: float) -> float:
	var number := _frame_at(seconds)
	if number == 0:
		return 0.0
	var frame: Dictionary = timeline["frames"][number]
	return number - 1 + clampf((seconds - frame["start"]) / frame["seconds"], 0.0, 1.0)


func _sample(track: Array, time: float) -> Dictionary:
	var i := 0
	while i < track.size() and track[i][0] <= time:
		i += 1
	var a: Array = track[maxi(i - 1, 0)]
	var b: Array = a
	var w := 0.0
	if i > 0 and i < track.size():
		b = track[i]
		w = _bend(a[8], (time - a[0]) / (b[0] - a[0]))
	return {
		"x": lerpf(a[1], b[1], w),
		"y": lerpf(a[2], b[2], w),
		"angle": lerpf(a[3], b[3], w),
		"scale": Vector2(lerpf(a[4], b[4], w), lerpf(a[5], b[5], w)),
		"opacity": lerpf(a[6], b[6], w),
		"lift": lerpf(a[7], b[7], w),
		"pose": a[9],
	}


func _bend(ease_name: String, u: float) -> float:
	match ease_name:
		"in":
			return u * u
		"out":
			return 1.0 - (1.0 - u) * (1.0 - u)
		"in-out":
			return u * u * (3.0 - 2.0 * u)
		"hold":
			return 0.0
		_:
			return u


func _place(sprite: Sprite2D, key: Dictionary, stands: Array) -> void:
	var cell: float = sheet["cell"]
	sprite.position = Vector2(key["x"] + stands[0], key["y"] + stands[1] - key["lift"]) * cell
	sprite.rotation = key["angle"] * TAU
	sprite.scale = key["scale"]
	sprite.modulate.a = key["opacity"]


# Who is nearer hides who is farther: Godot sorts children of a Node2D with y_sort_enabled.
func _add_sprite(pivot: String) -> Sprite2D:
	y_sort_enabled = true
	var sprite := Sprite2D.new()
	sprite.texture = _texture
	sprite.region_enabled = true
	sprite.centered = false
	sprite.offset = -Vector2(sheet[pivot][0], sheet[pivot][1])
	add_child(sprite)
	return sprite


func _show(sprite: Sprite2D, corner: Array) -> void:
	sprite.region_rect = Rect2(corner[0], corner[1], sheet["size"][0], sheet["size"][1])


func _add_background(about: Dictionary) -> void:
	var room := Sprite2D.new()
	room.texture = load(folder.path_join(about["image"]))
	room.centered = false
	room.z_index = -1
	room.scale = Vector2.ONE * (float(sheet["cell"]) / float(about["cell"]))
	room.offset = -Vector2(about["origin"][0], about["origin"][1])
	add_child(room)


func _read(path: String, format: String) -> Dictionary:
	var text := FileAccess.get_file_as_string(path)
	var found: Variant = JSON.parse_string(text) if text else null
	if not found is Dictionary or found.get("format") != format or found.get("version") != 1:
		push_error("%s is no %s of version 1" % [path, format])
		return {}
	return found
