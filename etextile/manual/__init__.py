"""The manual: its pages, and the code that builds them with Sphinx (`make manual`)."""
