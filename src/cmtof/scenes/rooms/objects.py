"""Small things that people put on what stands in a room, and where they put them."""

from cmtof.scenes.rooms import books, clutter, devices, food, sculpture, tableware, vessels
from cmtof.scenes.rooms.vessels import Maker

CATALOGUE: dict[str, Maker] = {
    **vessels.CATALOGUE,
    **tableware.CATALOGUE,
    **sculpture.CATALOGUE,
    **food.CATALOGUE,
    **books.CATALOGUE,
    **devices.CATALOGUE,
    **clutter.CATALOGUE,
}
"""Makers by name. All stand on z = 0 but the mask, which hangs on a wall."""

Group = list[tuple[str, float]]

groups: dict[str, Group] = {
    "dining table": [
        ("plate", 4), ("cutlery_set", 4), ("glass", 4), ("wine_bottle", 2), ("bowl", 2),
        ("fruit_bowl", 2), ("vase", 2), ("candlestick", 2), ("cup", 2), ("pitcher", 1.5),
        ("teapot", 1), ("bread", 1), ("cake", 0.5), ("pot", 0.7), ("decanter", 0.5),
        ("tray", 0.7), ("paper_sheets", 0.7), ("laptop", 0.5), ("orange", 0.4), ("pumpkin", 0.3),
        ("gift_box", 0.3),
        ("flowers_in_vase", 1.5), ("orchid", 0.4),
    ],
    "desk": [
        ("book_stack", 3), ("paper_sheets", 3), ("pen_cup", 3), ("mug", 2), ("open_book", 2),
        ("book", 2), ("magazine_pile", 1), ("picture_frame", 1.5), ("laptop", 1),
        ("telephone", 1), ("desk_fan", 0.7), ("box_file", 1.5), ("folder_row", 1),
        ("loudspeaker", 1), ("scissors", 1), ("glasses_case", 1), ("keys", 0.7), ("globe", 0.7),
        ("printer", 0.7), ("apple", 0.6), ("crumpled_paper", 1), ("tissue_box", 0.6),
        ("alarm_clock", 0.4), ("game_controller", 0.4), ("bottle", 0.7), ("owl_figure", 0.3),
        ("stone", 0.3), ("bust", 0.4),
        ("headphones", 1), ("cactus", 0.7), ("cable_bundle", 0.5),
    ],
    "coffee table": [
        ("magazine_pile", 3), ("book_stack", 2), ("book", 2), ("open_book", 1), ("mug", 2),
        ("cup", 2), ("fruit_bowl", 1.5), ("vase", 2), ("candle", 2), ("tray", 1.5), ("bowl", 1.5),
        ("game_controller", 1), ("glass", 1), ("wine_bottle", 0.6), ("chess_board", 0.7),
        ("glasses_case", 0.8), ("tissue_box", 0.8), ("laptop", 0.6), ("statuette", 0.5),
        ("shell", 0.5), ("stone", 0.4), ("keys", 0.5), ("toy_car", 0.5), ("bust", 0.3),
        ("flowers_in_vase", 1), ("orchid", 0.5), ("bonsai", 0.4),
    ],
    "kitchen worktop": [
        ("kettle", 2), ("toaster", 2), ("coffee_machine", 2), ("microwave", 1.2),
        ("blender", 1.2), ("jar", 3), ("bottle", 3), ("pot", 2), ("pan", 2), ("plate", 2),
        ("bowl", 2), ("mug", 2), ("glass", 1.5), ("bread", 1.5), ("fruit_bowl", 1.5),
        ("apple", 0.7), ("banana_bunch", 1), ("orange", 0.6), ("pear", 0.5), ("egg_carton", 1),
        ("tin_cans", 1.2), ("spray_bottle", 1), ("teapot", 1), ("jug", 1), ("cutlery_set", 0.8),
        ("radio", 0.8), ("tray", 0.6), ("wine_bottle", 1), ("pumpkin", 0.5), ("cake", 0.4),
        ("basket", 0.4),
        ("herb_pot", 1.2), ("crumpled_cloth", 1.2), ("folded_towels", 0.4),
    ],
    "shelf": [
        ("vase", 3), ("book_stack", 3), ("picture_frame", 3), ("bust", 2.5), ("statuette", 2),
        ("owl_figure", 1.5), ("animal_figure", 1.8), ("globe", 1.2), ("storage_box", 2),
        ("box_file", 1.5), ("folder_row", 1.2), ("bowl", 1.5), ("jar", 1.5), ("trophy", 1),
        ("skull", 0.6), ("shell", 1), ("stone", 0.8), ("candle", 1.2), ("candlestick", 1),
        ("radio", 0.8), ("loudspeaker", 1), ("basket", 1), ("toy_car", 0.8), ("teddy_bear", 0.8),
        ("alarm_clock", 0.7), ("magazine_pile", 1), ("book", 1), ("tin_cans", 0.3), ("urn", 0.7),
        ("jug", 0.7), ("decanter", 0.4), ("teapot", 0.5), ("gift_box", 0.3), ("hat", 0.4),
        ("trailing_ivy", 0.9), ("cactus", 0.7), ("spider_plant", 0.7), ("headphones", 0.3),
    ],
    "nightstand": [
        ("book", 3), ("book_stack", 2), ("alarm_clock", 3), ("glass", 2), ("glasses_case", 2),
        ("mug", 1.5), ("tissue_box", 1.5), ("candle", 1), ("picture_frame", 1.5),
        ("open_book", 0.7), ("bottle", 0.7), ("vase", 1), ("keys", 0.5), ("radio", 0.5),
        ("telephone", 0.5), ("shell", 0.4), ("owl_figure", 0.4),
        ("orchid", 0.4), ("cactus", 0.4), ("headphones", 0.4),
    ],
    "window sill": [
        ("vase", 2.5), ("candle", 1.5), ("stone", 1), ("shell", 1), ("owl_figure", 1),
        ("animal_figure", 1), ("watering_can", 1), ("jar", 1), ("bottle", 0.8),
        ("statuette", 0.8), ("book_stack", 0.7), ("picture_frame", 1), ("candlestick", 0.8),
        ("pumpkin", 0.3),
        ("herb_pot", 1.5), ("orchid", 1.5), ("cactus", 1.5), ("spider_plant", 1), ("bonsai", 0.6),
        ("flowers_in_vase", 1),
    ],
    "floor corner": [
        ("cardboard_box", 3), ("waste_bin", 2.5), ("basket", 2), ("storage_box", 2),
        ("shoes", 2.5), ("backpack", 1.5), ("suitcase", 1.5), ("guitar", 1), ("handbag", 1),
        ("book_stack", 1.5), ("umbrella_stand", 1), ("bucket", 0.8), ("magazine_pile", 0.8),
        ("laundry_basket", 1), ("toolbox", 0.6), ("urn", 0.7), ("loudspeaker", 1),
        ("camera_on_tripod", 0.5), ("broom", 0.5), ("table_fan", 0.7), ("paint_bucket", 0.4),
        ("crumpled_paper", 0.6), ("helmet", 0.5), ("ball_toy", 0.5),
        ("crumpled_cloth", 0.7), ("laundry_pile", 0.6), ("rope_coil", 0.3), ("cable_bundle", 0.4),
    ],
    "workbench": [
        ("toolbox", 3), ("paint_bucket", 2.5), ("tin_cans", 2), ("jar", 2), ("spray_bottle", 1.5),
        ("bottle", 1), ("bucket", 1), ("storage_box", 2), ("cardboard_box", 1.5), ("scissors", 1),
        ("radio", 1), ("mug", 1), ("paper_sheets", 0.7), ("helmet", 0.7), ("sewing_machine", 0.4),
        ("basket", 0.5), ("crumpled_paper", 0.6), ("watering_can", 0.5),
        ("rope_coil", 1), ("crumpled_cloth", 1.2), ("garden_hose", 0.6), ("cable_bundle", 0.8),
        ("headphones", 0.4),
    ],
    "bathroom": [
        ("bottle", 5), ("spray_bottle", 1.2), ("jar", 2), ("glass", 2), ("hair_dryer", 1.2),
        ("candle", 1), ("tissue_box", 1), ("basket", 0.7), ("shell", 0.6), ("stone", 0.4),
        ("bowl", 0.6), ("scissors", 0.4),
        ("folded_towels", 1.5), ("crumpled_cloth", 0.6),
    ],
    "mantel": [
        ("bust", 2.5), ("candlestick", 3), ("vase", 3), ("picture_frame", 3), ("alarm_clock", 1),
        ("urn", 1.5), ("statuette", 2), ("owl_figure", 1), ("animal_figure", 1.5), ("trophy", 1),
        ("candle", 1.5), ("globe", 1), ("radio", 0.8), ("decanter", 0.8), ("book_stack", 1),
        ("bowl", 1), ("fruit_bowl", 0.7), ("keys", 0.7), ("shell", 0.6), ("skull", 0.4),
        ("telephone", 0.5), ("loudspeaker", 0.7), ("gift_box", 0.3), ("hat", 0.3),
        ("flowers_in_vase", 1.2), ("orchid", 0.6), ("bonsai", 0.5),
    ],
    "sofa": [
        ("book", 2), ("open_book", 2), ("magazine_pile", 1.5), ("game_controller", 1.5),
        ("laptop", 1.5), ("teddy_bear", 1.5), ("handbag", 1), ("hat", 0.7), ("glasses_case", 0.7),
        ("ball_toy", 0.5), ("paper_sheets", 0.5),
        ("crumpled_cloth", 0.8), ("headphones", 0.5), ("throw_blanket", 0.8),
    ],
    "bed": [
        ("open_book", 2), ("book", 2), ("laptop", 2), ("teddy_bear", 2), ("handbag", 1),
        ("magazine_pile", 1), ("hat", 0.7), ("tray", 0.8), ("hair_dryer", 0.6),
        ("game_controller", 0.6), ("gift_box", 0.6), ("suitcase", 0.3), ("backpack", 0.5),
        ("paper_sheets", 0.5),
        ("crumpled_cloth", 0.8), ("folded_towels", 0.7), ("laundry_pile", 0.6),
        ("throw_blanket", 1), ("headphones", 0.3),
    ],
    "toy corner": [
        ("teddy_bear", 3), ("building_blocks", 3), ("toy_car", 3), ("toy_train", 3),
        ("ball_toy", 3), ("book_stack", 1.5), ("open_book", 1), ("storage_box", 1.5),
        ("basket", 1), ("cardboard_box", 1), ("paper_sheets", 1), ("game_controller", 0.4),
        ("shoes", 0.6), ("animal_figure", 0.5), ("backpack", 0.5),
        ("crumpled_cloth", 0.3),
    ],
}  # fmt: skip
"""What people put at a place, and how often: (name, weight)."""
