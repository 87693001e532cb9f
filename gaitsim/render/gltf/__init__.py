"""Write glTF 2.0: a document with its buffers, and the meshes and rotations of bodies."""
