"""Pictures: scenes, maps, plots and pages."""
