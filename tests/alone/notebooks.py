"""What the extra `notebooks` promises: a chapter runs from its .ipynb, outside the checkout."""

import nbformat
from nbclient import NotebookClient

NotebookClient(nbformat.read("16_stereo.ipynb", as_version=4), timeout=600).execute()
