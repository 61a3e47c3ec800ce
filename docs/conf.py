"""The site of the documentation: `make docs` builds it from the pages of this folder, without a network."""

from __future__ import annotations

import sys
from pathlib import Path

import jkrcli

sys.path.insert(0, str(Path(__file__).parent))  # site_parts

project = "jkr"
author = "The jkr contributors"
version = release = jkrcli.__version__
extensions = ["myst_parser", "site_parts.browser", "site_parts.generated", "site_parts.mathml", "site_parts.notebooks"]
exclude_patterns = ["examples", "peers", "studies", "site_parts"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
suppress_warnings = ["config.cache"]
html_theme = "furo"
html_title = f"jkr {version}"
html_static_path = ["site_parts/static"]
html_css_files = ["site.css"]
html_copy_source = False
smartquotes = False  # of options, -- stays two
