"""Read and write gait files, which hold joint angles: MATLAB, CSV and NumPy."""
