#!/usr/bin/env python3
"""A device in another program: sends poses to `sqmap touch --device network` and prints the forces that come back.

Here the device is a point that goes down along z until it feels something, a little further, and up again; a program with
a real device sends that one's poses and exerts the forces instead. Nothing but the standard library; the messages are those
of docs/devices.md.

When the safety filter has let go for good (a fault: silence, a speed above 1 m/s, poses that cannot be) it says so; Enter goes
on.

usage: network_client.py [--host 127.0.0.1] [--port 47710] [--seconds 6] [--at X Y] [--from Z] [--to Z] [--press M]
"""
import argparse
import math
import select
import socket
import struct
import sys
import time

HEADER = struct.Struct("<4sHHQ")  # magic, version, kind, sequence
HELLO, WELCOME, REFUSED, POSE, WRENCH, BYE, RESUME = range(1, 8)
REASONS = {1: "another client is connected", 2: "another version", 3: "the hello is malformed", 4: "another device was opened"}
FAULTS = {1: "refused limits", 2: "poses or forces that are not finite", 4: "no new pose for 100 ms", 8: "too fast", 16: "stopped"}
SILENCE = 0.020  # s without a wrench: exert nothing


def message(kind, sequence, body=b""):
    return HEADER.pack(b"SQMN", 1, kind, sequence) + body


def hello():
    zones, flags = 1, 1 | 2 | 4  # rotates, takes force, takes torque
    rate, max_force, max_torque, continuous_force = 1000.0, 3.0, 0.1, 1.0
    damping, coulomb_friction, resolution, delay = 1.0, 0.05, 20e-6, 0.0
    return message(HELLO, 1, struct.pack("<2I8d32s", zones, flags, rate, max_force, max_torque, continuous_force, damping,
                                         coulomb_friction, resolution, delay, b"example"))


def connect(link, patience):
    """Says hello until welcomed; returns the token that every pose carries."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            link.send(hello())
            answer = link.recv(2048)
        except (ConnectionRefusedError, socket.timeout):
            time.sleep(0.05)  # nobody listens yet
            continue
        magic, _, kind, _ = HEADER.unpack_from(answer)
        if magic == b"SQMN" and kind == WELCOME:
            return struct.unpack_from("<Q", answer, HEADER.size)[0]
        if magic == b"SQMN" and kind == REFUSED:
            reason = struct.unpack_from("<I", answer, HEADER.size)[0]
            raise SystemExit(f"refused: {REASONS.get(reason, reason)}")
    raise SystemExit("nobody answers: start `sqmap touch --device network` first")


def entered(watched):
    """True where Enter was pressed; watched loses standard input once that has ended."""
    if not watched or not select.select(watched, [], [], 0)[0]:
        return False
    line = sys.stdin.readline()
    if not line:
        watched.clear()
    return bool(line)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=47710)
    parser.add_argument("--seconds", type=float, default=6)
    parser.add_argument("--at", type=float, nargs=2, default=(0, 0), metavar=("X", "Y"), help="m, where it goes down")
    parser.add_argument("--from", dest="top", type=float, default=0.35, help="m, where the point starts along z")
    parser.add_argument("--to", dest="bottom", type=float, default=0, help="m, how far it goes where it feels nothing")
    parser.add_argument("--press", type=float, default=0.003, help="m, how much further it goes once it feels something")
    options = parser.parse_args()

    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.connect((options.host, options.port))
    link.settimeout(0.2)
    token = connect(link, 10)
    link.setblocking(False)

    begin = heard = time.monotonic()
    sequence, force, strongest, answers = 0, (0.0, 0.0, 0.0), 0.0, 0
    ended, faults, keyboard = False, 0, [sys.stdin]
    height, turn, before = options.top, options.bottom, begin
    speed = 2 * (options.top - options.bottom) / options.seconds
    down = True
    while not ended and (now := time.monotonic()) - begin < options.seconds:
        height = min(height + (-speed if down else speed) * (now - before), options.top)
        before = now
        if height <= turn:
            down = False
        position = (*options.at, height)
        quaternion = (1.0, 0.0, 0.0, 0.0)  # w, x, y, z
        sequence += 1
        buttons, flags = 0, 0
        try:
            link.send(message(POSE, sequence, struct.pack("<Qd2I7d", token, now, buttons, flags, *position, *quaternion)))
            if entered(keyboard):
                link.send(message(RESUME, 0, struct.pack("<Q", token)))
            while True:
                answer = link.recv(2048)
                magic, _, kind, _ = HEADER.unpack_from(answer)
                if magic != b"SQMN":
                    continue
                if kind == WRENCH:
                    _, zones, told = struct.unpack_from("<Q2I", answer, HEADER.size)
                    force = struct.unpack_from("<3d", answer, HEADER.size + 16)
                    heard, answers = now, answers + 1
                    if told >> 16 != faults:
                        faults = told >> 16
                        why = ", ".join(words for bit, words in FAULTS.items() if faults & bit)
                        print(f"no force: {why}; Enter goes on" if faults else "goes on", flush=True)
                elif kind == BYE:
                    ended = True
        except BlockingIOError:
            pass
        except ConnectionRefusedError:
            ended = True
        if now - heard > SILENCE:
            force = (0.0, 0.0, 0.0)  # the other side is silent: let go
        # A real device exerts the force here.
        strongest = max(strongest, math.hypot(*force))
        if down and math.hypot(*force) > 0.02:
            turn = max(turn, height - options.press)  # the first time counts: later ones lie lower
        time.sleep(0.001)
    link.setblocking(True)
    try:
        link.send(message(BYE, sequence + 1, struct.pack("<Q", token)))
    except ConnectionRefusedError:
        pass
    print(f"{sequence} poses sent, {answers} answers, strongest force {strongest:.3f} N")
    if strongest == 0:
        print(f"nothing was felt at x {options.at[0]:g}, y {options.at[1]:g}, z {options.top:g} to {options.bottom:g} m: choose a "
              "way that starts outside the object and ends inside, with --at X Y, --from Z and --to Z")


if __name__ == "__main__":
    main()
