"""Writing of glTF 2.0: documents with their buffers, and the meshes and rotations of bodies."""
