"""The checks of each kind of plugin, ordinary tests that `gaitsim_testing.plugin` adds."""
