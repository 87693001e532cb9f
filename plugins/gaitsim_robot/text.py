"""The robot's text: a robot as one normalised MJCF document, which needs no other file.

It is what the option `organism.model` holds, so that an experiment file, a checkpoint and a
champion contain their robot.

- One body of the world, the trunk, with a free joint; every other joint is a hinge with a range.
- Every body has its inertia written out.
- Geoms are boxes, spheres, capsules, cylinders, ellipsoids, and convex meshes whose vertices stand
  in the text.
- The largest torque of a joint is its `actuatorfrcrange`; its largest speed, rad/s, is its `user`
  value, 0 where it is not known.
- Equality constraints keep mimic joints and closed linkages.
- At most one keyframe, `stand`.
- No ground, actuators, sensors, includes or names of files.
"""
