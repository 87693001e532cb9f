"""What commands do. Command modules declare options alone, so that `--help` stays quick."""
