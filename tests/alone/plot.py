"""What the extra `plot` promises: figures, and the bars and curves that they are made of."""

from pathlib import Path

from matplotlib.figure import Figure

from cmtof_book import plotting

plotting.begin()
figure = Figure()
plotting.bars(figure.subplots(), {"crt": [0.1, 0.2], "beat": [0.3, 0.4]}, ["wall", "room"])
figure.savefig("bars.png")
assert Path("bars.png").is_file()
