"""What the extra `plot` promises: figures, and the dots and curves that they are made of."""

from pathlib import Path

from matplotlib.figure import Figure

from cmtof_book import plotting

plotting.begin()
figure = Figure()
plotting.dots(
    figure.subplots(), {"crt": [0.1, 0.2], "beat": [0.3, 0.4]}, ["wall", "room"]
)
figure.savefig("dots.png")
assert Path("dots.png").is_file()
