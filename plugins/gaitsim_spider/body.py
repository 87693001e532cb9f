"""The spider's body: geometry, masses and limits. SI units, radians.

Frame: x forward, y left, z up; the origin is the centre of the body, the hips lie in its
plane. Legs in the order L1 L2 L3 L4 R1 R2 R3 R4, front to back.
"""

import math

import numpy as np

LEGS = ("L1", "L2", "L3", "L4", "R1", "R2", "R3", "R4")
SEGMENTS = ("coxa", "femur", "tibia")
SIDES = (LEGS[:4], LEGS[4:])
LEG_JOINTS = {leg: tuple(f"{leg} {segment}" for segment in SEGMENTS) for leg in LEGS}
JOINTS = tuple(joint for joints in LEG_JOINTS.values() for joint in joints)

FRAMES = 300
FRAME_RATE = 30.0  # Hz

BODY_LENGTH, BODY_WIDTH = 0.20, 0.14  # m
BODY_MASS = 0.8  # kg
_CORNERS = [(1, 1), (1, -1), (-1, -1), (-1, 1)]
OUTLINE_NAMES = ("front", "right side", "back", "left side")
OUTLINE = np.zeros((4, 2, 3))  # m, both ends of each edge
OUTLINE[:, 0, :2] = np.multiply(_CORNERS, [BODY_LENGTH / 2, BODY_WIDTH / 2])
OUTLINE[:, 1] = np.roll(OUTLINE[:, 0], -1, axis=0)

HIP_X = np.array([0.075, 0.025, -0.025, -0.075] * 2, dtype=np.float32)  # m
HIP_Y = 0.07  # m, to the leg's own side
SIDE = np.array([1.0] * 4 + [-1.0] * 4, dtype=np.float32)  # left +1, right −1
# Where a leg points at rest, from the sideways axis towards the front.
AZIMUTH = np.radians([45.0, 15.0, -15.0, -45.0] * 2).astype(np.float32)

COXA, FEMUR, TIBIA = 0.03, 0.08, 0.12  # m
COXA_MASS, FEMUR_MASS, TIBIA_MASS = 0.01, 0.02, 0.02  # kg

# Pitch at rest against the horizontal. Joint angles are offsets from this pose.
FEMUR_PITCH = math.radians(30.0)
TIBIA_PITCH = math.radians(-80.0)
# A foot is the centre of a small ball at the tip of the tibia, so that the body's
# centre stands at 0.0782 + 0.008 = 0.0862 m.
FOOT_RADIUS = 0.008  # m
STANDING_HEIGHT = FOOT_RADIUS - FEMUR * math.sin(FEMUR_PITCH) - TIBIA * math.sin(TIBIA_PITCH)

ANGLE_LIMIT = math.radians(30.0)  # either way from rest, every joint
STEP_LIMIT = math.radians(5.0)  # a frame, i.e. 150 °/s
