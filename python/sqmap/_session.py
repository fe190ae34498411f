"""Forces: a tool on a model, with the safety filter between the computed force and the device."""
from __future__ import annotations

import contextlib
from typing import Any, NamedTuple, Optional

import numpy as np

from . import _library as c
from ._arrays import (LAYERS, Layer, address, count, fill_pose, flag, instance, number, numbers, paper_reading, pointer, pose_of,
                      refuse, rows)
from ._bodies import Probe
from ._model import Model
from ._owned import Owned

MODES = {"direct": 1, "proxy": 2, "coupled": 3}
FORCES, FRICTION_LAWS = ("full", "paper"), ("default", "coulomb", "paper", "none")
STOP, RESUME, RESTART, HELD, DISCONNECTED = 1, 2, 4, 8, 16


def matrix_of(pose: c.Pose) -> np.ndarray:
    """(4, 4) [rotation | translation]."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = np.reshape(pose.rotation, (3, 3)), pose.translation
    return out


class Force(NamedTuple):
    """The results of one tick. N, N m, m; world axes."""

    force: np.ndarray      #: (3,) for the device: finite, within the limits, zero when anything is wrong
    torque: np.ndarray     #: (3,) about the tool
    commanded: np.ndarray  #: (3,) before the safety filter
    depth: float           #: m; of a proxy the stretch of its spring
    normal: np.ndarray     #: (3,) unit, outward; zero where free
    status: int            #: bits of haptic::StepStatus
    acted: int             #: bits of haptic::SafetyStep: 1 something is not finite, or the pose no rotation
    faults: int            #: bits of haptic::SafetyFault; any of them means zero until RESUME
    engaged: bool          #: all that is commanded is sent, within limits
    tool: np.ndarray       #: (4, 4) where the tool is: the device's pose, the proxy's or the coupled body's


class Simulation(NamedTuple):
    """A simulated device's ticks of one millisecond, row by row."""

    positions: np.ndarray  #: (n, 3) m, of the stylus
    forces: np.ndarray     #: (n, 3) N, sent to it
    depths: np.ndarray     #: (n,) m
    tools: np.ndarray      #: (n, 3) m, of the tool: the stylus, the proxy or the coupled body


class Session(Owned):
    """A ball, a point or the surface of a tool that touches a model. Metres, newtons, seconds. Calls of several threads take turns.

    metres_per_unit: of the model's mesh. pose: (4, 4) of the model in the world. radius: of the ball, m; 0: a point.
    stiffness: N/m. damping: N s/m. friction: Coulomb's; 0: none. max_force, max_torque, continuous_force: what the device holds;
    0: unknown, so careful. force_limit, torque_limit: the user's, 0: 2 N and 0.1 N m or the device's, whichever is less.
    dead_man: force only in ticks with HELD. mode: "direct", the tool is where the device is; "proxy", it stays on the surface and
    the device pulls it; "coupled", it is a light body on springs. side_path: m, of the proxy; above 0 it stays on its side of what
    is thinner than the press is deep, and takes another as the device moves so far. tool: a Probe with triangles, metres, whose
    surface touches in place of a ball; edges: where few of its points touch, its edges and faces do too, which a model with a closed
    surface and the exact layer allows. zone: m, the impact sphere about the tool's pose, whose contacts count (section 6.1), of a tool
    or of a ball with the paper's force; 0: all. Research software, not a safety device.

    Of a paper model: force "paper" takes eqs. 21, 26, 32 and 33 on its smoothed map, with f_c (N) and k_f (1/m).
    friction_law: "default", "coulomb", "paper" (eq. 33) or "none". projector: how feet are found, "newton", "pyramid" or "printed"
    (with it the paper's force has eq. 21's depth). layer "gate": 2 or 3 by gate (k_L, from 1). nearest_steps: to the nearest surface,
    0 to 100. gaps: openings behind the first surface count. pruning: a part that proves a point free outweighs others. offset: move
    the surface out by eq. 12."""

    _closes = "sqmap_close_session"

    def __init__(self, model: Model, *, metres_per_unit: float = 1.0, pose: Any = None, radius: float = 0.0,
                 stiffness: float = 500.0, damping: float = 0.0, friction: float = 0.4, layer: Layer = 3, max_force: float = 0.0,
                 max_torque: float = 0.0, continuous_force: float = 0.0, force_limit: float = 0.0, torque_limit: float = 0.0,
                 dead_man: bool = False, mode: str = "direct", side_path: float = 0.0, force: str = "full",
                 friction_law: str = "default", f_c: float = 0.2, k_f: float = 100.0, projector: str = "newton", gate: int = 10,
                 nearest_steps: int = 2, gaps: bool = True, pruning: bool = True, offset: bool = False,
                 tool: Optional[Probe] = None, edges: bool = True, zone: float = 0.0) -> None:
        instance(model, Model, "model")
        if isinstance(layer, bool) or not isinstance(layer, (int, str)) or layer not in LAYERS:
            raise refuse("layer", f"is {layer!r}", 'take 1, 2, 3, "exact", "auto" or "gate"')
        if not isinstance(mode, str) or mode not in MODES:
            raise refuse("mode", f"is {mode!r}", 'take "direct", "proxy" or "coupled"')
        laws = (("force", force, FORCES), ("friction_law", friction_law, FRICTION_LAWS))
        for name, value, words in laws:
            if not isinstance(value, str) or value not in words:
                raise refuse(name, f"is {value!r}", f"take one of {', '.join(words)}")
        for name, value in (("f_c", number(f_c, "f_c")), ("k_f", number(k_f, "k_f"))):
            if value < 0:
                raise refuse(name, f"is {value}", "give a number from 0 on")
        reading = paper_reading(projector, gate, nearest_steps, gaps, pruning, offset)
        sizes = {name: number(value, name) for name, value in
                 {"metres_per_unit": metres_per_unit, "radius": radius, "stiffness": stiffness, "damping": damping,
                  "friction": friction, "max_force": max_force, "max_torque": max_torque, "continuous_force": continuous_force,
                  "force_limit": force_limit, "torque_limit": torque_limit, "side_path": side_path, "zone": zone}.items()}
        for name in ("metres_per_unit", "stiffness"):
            if sizes[name] == 0:  # zero stands for the default in C
                raise refuse(name, "is 0", "give a number above zero")
        if sizes["friction"] == 0:
            sizes["friction"] = -1.0
        elif sizes["friction"] < 0:
            raise refuse("friction", f"is {friction}", "give a number from 0 on")
        options = c.SessionOptions(pose=pointer(pose_of(pose)), layer=LAYERS[layer], has_dead_man=flag(dead_man, "dead_man"),
                                   mode=MODES[mode], force=FORCES.index(force), friction_law=FRICTION_LAWS.index(friction_law),
                                   f_c=f_c or -1.0, k_f=k_f or -1.0, **reading, **sizes)
        options.without_edges = not flag(edges, "edges")
        handle = c.Handle()
        with model.use("model") as touched, contextlib.ExitStack() as held:
            if tool is not None:
                options.tool = held.enter_context(instance(tool, Probe, "tool").use("tool"))
            c.call("sqmap_make_session", touched, options, handle)
        super().__init__(handle)
        self._sequence = 0

    def tick(self, pose: Any, time: float, *, sample_time: Any = None, sequence: Any = None, acts: int = 0) -> Force:
        """One tick. pose: (4, 4) of the tool in the world, m, or its position (3,). time: s, monotonic. sample_time: when the
        device was read, default now; sequence: of the reading, default a fresh one; acts: STOP | RESUME | RESTART | HELD |
        DISCONNECTED. What is not finite, or no rotation, gives zero force and says so in acted, after three ticks in faults."""
        matrix = numbers(pose, "pose")
        if matrix.shape not in ((3,), (3, 4), (4, 4)):
            raise refuse("pose", f"has the shape {matrix.shape}", "give a matrix (4, 4) or (3, 4), or a position (3,)")
        if sequence is None:
            self._sequence += 1
            sequence = self._sequence
        now = number(time, "time")
        tick = c.Tick(time=now, sample_time=now if sample_time is None else number(sample_time, "sample_time"),
                      sequence=count(sequence, "sequence", 2**64 - 1), acts=count(acts, "acts", 31))
        if matrix.shape == (3,):
            tick.pose.rotation[:], tick.pose.translation[:] = (1, 0, 0, 0, 1, 0, 0, 0, 1), matrix.tolist()
        else:
            fill_pose(tick.pose, matrix, "pose", answers_nan=True)
        out = c.Force()
        with self.turn, self.use() as handle:
            c.call("sqmap_tick_session", handle, tick, out)
        return Force(np.array(out.force), np.array(out.torque), np.array(out.commanded), out.depth, np.array(out.normal), out.status,
                     out.acted, out.faults, bool(out.is_engaged), matrix_of(out.tool))

    def simulate(self, targets: Any) -> Simulation:
        """Drives the session with a simulated stylus of 70 g in a hand that holds it as a pen and wants to be at targets (n, 3),
        m, one a millisecond. No clock: the same targets give the same bits. Goes on from call to call."""
        wanted = rows(targets, "targets")
        n = len(wanted)
        positions, forces, depths, tools = np.empty((n, 3)), np.empty((n, 3)), np.empty(n), np.empty((n, 3))
        simulation = c.Simulation(targets=address(wanted), count=n, positions=address(positions), forces=address(forces),
                                  depths=address(depths), tools=address(tools))
        with self.turn, self.use() as handle:
            c.call("sqmap_simulate", handle, simulation)
        return Simulation(positions, forces, depths, tools)
