"""The checks of each kind of plugin, ordinary tests that `gaitsim.testing.plugin` adds."""
