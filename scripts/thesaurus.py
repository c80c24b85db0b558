"""Further words for the kinds of things and furniture that perception knows, so that others of their kind are near one.

None of them has a word that only the unseen tasks use (tests/scripts/test_thesaurus.py): how those are
read stays a test.
"""

from __future__ import annotations

THINGS: dict[str, str] = {
    "box": (
        "packing box|moving box|corrugated box|shipping box|paper box|package|delivery box|brown box|"
        "cardboard carton|pasteboard box|packaging box|cardboard package|packet|shipment"
    ),
    "crate": (
        "wood crate|fruit crate|apple crate|timber crate|plank crate|packing crate|crate of wood|vegetable crate|"
        "milk crate"
    ),
    "basket": (
        "rattan basket|cane basket|willow basket|wickerwork basket|straw basket|braided basket|shopping basket|"
        "basket of wicker|plaited basket|weave basket|handwoven basket"
    ),
    "trash_bin": (
        "bin|rubbish bin|dustbin|wastebasket|waste basket|wastepaper basket|litter bin|pedal bin|refuse bin|"
        "bin for rubbish|trash basket|recycling bin|waste can|ash can"
    ),
    "tote": (
        "storage bin|plastic box|plastic bin|plastic crate|storage crate|plastic container|tub|storage container|"
        "lidded tote|organizer box|stackable box|storage tub|container|keeping box"
    ),
    "laundry_basket": (
        "clothes basket|linen basket|laundry bin|dirty clothes basket|washing bin|basket for laundry|linen bin|"
        "basket of washing|laundry crate"
    ),
    "barrel": (
        "wine barrel|oak barrel|beer barrel|barrel|rain barrel|whisky barrel|wood barrel|beer keg|hogshead|"
        "wine keg|tun|firkin"
    ),
    "bucket": (
        "water bucket|cleaning bucket|plastic bucket|scrub bucket|mopping pail|water pail|cleaning pail|bucketful"
    ),
    "gift_box": "gift|birthday present|gift package|christmas present|box with a bow|present box|surprise",
    "chest": (
        "wood chest|old chest|pirate chest|trunk|blanket chest|hope chest|storage chest|coffer|strongbox|"
        "wooden trunk|treasure box|jewellery chest|memory box|strong box|sea chest"
    ),
    "plant": (
        "pot plant|green plant|flower pot|flowerpot|plant in a pot|leafy plant|fern|rubber plant|potted flower|"
        "foliage plant|plant pot|shrub|flower|planter|house flower|greenery"
    ),
    "lamp": "desk lamp|bedside lamp|small lamp|lamp with a shade|shade lamp|light|desk light|table light|lampshade",
    "floor_lamp": "floor lamp|tall lamp|torchiere|floor light|stand lamp|long lamp|post lamp|tall light",
    "vase": (
        "flower vase|pottery vase|china vase|porcelain vase|clay vase|jar|amphora|pitcher|ornamental vase|jug|"
        "clay jar|ceramic jar|porcelain jar|pottery|ewer|earthen vessel"
    ),
    "lantern": "hurricane lantern|storm lantern|camping lantern|garden lantern|kerosene lamp|camp light",
    "globe": "earth globe|terrestrial globe|desk globe|earth model|geographic globe|globe map|planet earth",
    "mantel_clock": (
        "carriage clock|bracket clock|alarm clock|desk clock|timepiece|clock for the mantelpiece|old clock|"
        "mantelpiece clock|wooden clock"
    ),
    "speaker": (
        "stereo speaker|audio speaker|music box speaker|bookshelf speaker|sound box|subwoofer|speaker box|"
        "monitor speaker|sound speaker|amplifier|public address speaker|loud speaker|tannoy"
    ),
    "monitor": "display|computer display|lcd monitor|display monitor|visual display unit",
    "laptop": "portable computer|open laptop|macbook|ultrabook|netbook|chromebook|mobile computer",
    "printer": (
        "laser printer|office printer|document printer|color printer|paper printer|photo printer|home printer|"
        "printing machine|ink printer|copier"
    ),
    "radio": (
        "radio set|transistor radio|portable radio|old radio|kitchen radio|fm radio|wireless|radio receiver|"
        "tabletop radio|vintage radio|desk radio"
    ),
    "fan": (
        "ventilator|tabletop fan|cooling fan|room fan|air fan|oscillating fan|small fan|fan|air blower|"
        "electric ventilator"
    ),
    "toaster": "toast maker|toasting machine|kitchen toaster|electric toaster|toasting appliance|sandwich toaster",
    "cooking_pot": (
        "cooking pan|pan|casserole|soup pot|stew pot|stewpot|kitchen pot|pasta pot|saucepot|sauce pot|cook pot|"
        "cooking pan with a lid|skillet|boiling pot|cauldron"
    ),
    "microwave": "countertop microwave|kitchen microwave|microwave cooker|microwave appliance|microwaving machine",
    "coffee_maker": (
        "coffee pot|espresso machine|espresso maker|filter coffee machine|drip coffee maker|percolator|"
        "coffee percolator|coffeemaker|coffee brewing machine|cappuccino machine|filter machine|brewing machine"
    ),
    "kettle": (
        "water kettle|water boiler|teakettle|hot water kettle|kitchen kettle|whistling kettle|cordless kettle|"
        "teapot|boiler"
    ),
    "rice_cooker": (
        "multicooker|rice pot|rice steamer|pressure cooker|slow cooker|rice boiler|multi cooker|"
        "electric rice cooker|electric pot|steam cooker|electric steamer|crockpot"
    ),
    "bread_bin": (
        "bread container|breadbox|bread chest|bread holder|loaf box|bread crock|breadbin|bread storage|"
        "bread keeper|loaf bin|bread case"
    ),
    "fruit_bowl": (
        "bowl with fruit|bowl of apples|fruit dish|fruit basket|bowl|apple bowl|dish of fruit|fruit tray|"
        "bowl of oranges|fruits|fruit plate|bowl full of fruit"
    ),
    "suitcase": (
        "trolley case|luggage|rolling suitcase|wheeled suitcase|baggage|cabin case|travel bag|roller case|"
        "hardside luggage|trolley suitcase|traveling case|valise|travel trunk"
    ),
    "backpack": (
        "knapsack|schoolbag|bookbag|daypack|hiking backpack|packsack|student backpack|kit bag|shoulder bag|"
        "satchel|haversack|book bag"
    ),
    "duffel_bag": (
        "sport bag|training bag|holdall|fitness bag|workout bag|weekend bag|carryall|sportsbag|athletic bag|"
        "gear bag|kitbag|football bag"
    ),
    "stool": (
        "round seat|low stool|padded stool|seat|tabouret|wooden stool|milking stool|vanity stool|cushioned stool|"
        "circular stool|round seat without a back|small stool|piano stool"
    ),
    "dining_chair": (
        "kitchen chair|table chair|side chair|straight chair|padded chair|chair with a back|wooden chair|"
        "fabric chair|seat with a back|cushioned chair|soft chair|covered chair"
    ),
    "bar_stool": (
        "high stool|tall stool|barstool|pub stool|breakfast bar stool|stool for the bar|kitchen bar stool|"
        "bar chair|bar seat|high seat|breakfast stool"
    ),
    "pouf": (
        "pouffe|footrest|hassock|tuffet|poof|leather pouf|round pouf|padded footrest|upholstered footrest|beanbag|"
        "bean bag|foot rest|seat cushion|floor seat"
    ),
    "step_stool": (
        "stepping stool|kick stool|little steps|kitchen steps|stool with steps|step|mini ladder|foot step|"
        "stool to step on|foot bench"
    ),
    "bedside_table": "bedstand|bedside stand|bedroom table|nighttable|bedside unit",
    "side_table": (
        "small table|lamp table|accent table|little table|snack table|sofa table|drinks table|round side table|"
        "table for a lamp|corner table|extra table|small side table|flower table"
    ),
    "cushion": "sofa cushion|couch cushion|scatter cushion|soft cushion|bolster|headrest|back cushion|throw cushion",
    "blanket_stack": (
        "folded blankets|blanket pile|blanket stack|heap of blankets|stacked blankets|blankets|stack of throws|"
        "pile of throws|folded quilts|stack of plaids|pile of towels|folded bedding|throws|heap of covers|bedding"
    ),
    "book_stack": (
        "books|book stack|book pile|heap of books|stacked books|piled books|stack of novels|pile of novels|"
        "some books|column of books|stack of volumes|several books|textbooks|heap of volumes"
    ),
    "toolbox": (
        "tool box|tool kit|box of tools|tools|toolkit|toolcase|workman's box|mechanic's box|box with tools|"
        "tool carrier|tool set|tool bag|case of tools|case with tools|tool container"
    ),
    "jerry_can": (
        "jerrycan|petrol can|gas can|gasoline can|fuel container|plastic can|gasoline container|petrol container|"
        "liquid container|water can"
    ),
    "paint_can": "paint bucket|paint pot|paint pail|pot of paint|bucket of paint|paint container|paint|wall paint",
    "cable_reel": (
        "cable spool|wire reel|wire spool|extension reel|spool of cable|reel of cable|cord reel|cable roll|"
        "coil of cable|cable coil|power cable reel"
    ),
}
"""Kind of object (`hv_sim.objects.OBJECT_KINDS`) -> more words for it."""
FURNITURE: dict[str, str] = {
    "sofa": (
        "loveseat|sectional|divan|chesterfield|davenport|lounge|corner sofa|daybed|long seat|futon|canape|"
        "sofa seat"
    ),
    "armchair": (
        "lounge chair|club chair|recliner|upholstered armchair|wing chair|comfy chair|cosy chair|soft armchair|"
        "fireside chair|comfortable chair|relaxing chair|lazy chair|reclining chair|big chair"
    ),
    "coffee_table": (
        "living room table|sofa table|lounge table|center table|table in front of the sofa|low living room table|"
        "magazine table"
    ),
    "tv_stand": (
        "tv unit|tv table|media console|tv bench|tv cabinet|entertainment center|tv console|media unit|"
        "tv furniture|tv board"
    ),
    "console_table": (
        "console|entry table|hallway table|entryway table|foyer table|narrow table|sofa back table|corridor table|"
        "entrance table|wall table|vestibule table|lobby table|slim table"
    ),
    "bookshelf": "bookshelves|bookrack|book rack|book cabinet|book case|library|book stand",
    "rug": "mat|floor mat|area rug|floor rug|carpeting|floor covering|persian rug|throw rug|runner|living room rug",
    "side_table": "small table|lamp table|accent table|sofa end table|little table|corner table|drinks table",
    "dining_table": (
        "eating table|dining room table|table for meals|supper table|large table|big table|family table|"
        "meal table|table for dining|lunch table|table to eat at|main table"
    ),
    "dining_chair": "side chair|wooden chair|kitchen chair|table chair|straight chair|desk chair",
    "cabinet": (
        "storage cabinet|closed cabinet|cupboards|low cabinet|wooden cabinet|sideboard cabinet|cabinet with doors|"
        "press|storage unit"
    ),
    "bench": (
        "padded bench|long bench|seat bench|bench seat|wooden bench|entryway bench|cushioned bench|banquette|"
        "soft bench|sitting bench|fabric bench"
    ),
    "floor_lamp": "floor light|tall lamp|torchiere|standing lamp|stand lamp|tall light",
    "potted_tree": (
        "tree|tree in a pot|large plant|tall plant|palm|ficus|fig tree|palm tree|big potted plant|house tree|"
        "room tree|tree plant|potted palm|inside tree"
    ),
    "round_coffee_table": (
        "round table|circular table|circular coffee table|disc table|round living room table|round lounge table|"
        "round sofa table"
    ),
    "sideboard": (
        "hutch|server|dining sideboard|long cabinet|dresser base|long low cabinet|credence|sideboard for dishes|"
        "dining room cabinet|food counter"
    ),
    "record_cabinet": (
        "vinyl cabinet|lp cabinet|record player stand|vinyl storage|record storage|lp stand|record unit|"
        "vinyl stand|record rack|turntable stand|record furniture|album stand"
    ),
    "piano": (
        "klavier|pianoforte|wall piano|grand piano|keyboard instrument|vertical piano|cottage piano|spinet|"
        "piano instrument"
    ),
    "fireplace": "chimney|chimneypiece|mantelpiece|mantel|wood burner|fireside|ingle|inglenook|stove fireplace|grate",
    "display_cabinet": "showcase|display case|china cabinet|curio cabinet|vitrine|show cabinet",
    "double_bed": "bedstead|mattress|double bedstead",
    "single_bed": "cot|bunk",
    "wardrobe": "armoire|clothes cabinet|clothes press|closets",
    "dresser": "bureau|drawer chest|commode|tallboy|highboy|drawer unit|lowboy|drawer cabinet",
    "nightstand": "bedstand|bedside unit|bedside stand|bedside drawer|nighttime stand|bedside chest",
    "desk": (
        "office desk|computer desk|writing table|secretary desk|homework table|office table|student desk|"
        "desk for writing|studying table|computer table|learning table|homework desk"
    ),
    "vanity": (
        "vanity table|makeup table|vanity desk|beauty table|mirror table|cosmetics table|powder table|"
        "toilet table|makeup vanity|table with a mirror|hairdressing table|dresser table with a mirror|"
        "make up desk"
    ),
    "low_bookcase": "short bookshelf|low bookshelf|small bookshelf|low shelving|low rack",
    "shoe_rack": (
        "shoe stand|rack for shoes|shoe storage|footwear rack|boot rack|shoe organizer|shoe cabinet|"
        "footwear stand|shoe storage bench|shoes rack|footwear bench|bench for shoes"
    ),
    "clothes_rack": (
        "coat rack|clothing rack|clothes rail|clothes stand|coat stand|hanging rail|clothes hanger|dress rack|"
        "rail for clothes|coat hanger|hanger stand|clothing stand|apparel rack|clothes hanging rack"
    ),
    "standing_mirror": "floor mirror|tall mirror|long mirror|cheval mirror|wall mirror|body mirror",
    "kitchen_counter": (
        "counter|countertops|kitchen top|kitchen unit|kitchen bench|counter unit|kitchen surface|"
        "kitchen worksurface|counter top|base cabinets|food preparation surface"
    ),
    "sink_counter": (
        "sink|kitchen sink|wash basin|counter with the sink|sink cabinet|washbasin|basin|counter with a sink|"
        "dish sink|sink bench|sinks"
    ),
    "stove": (
        "range|hob|gas stove|electric stove|kitchen range|kitchen stove|stovetop|cooktop|cooking range|gas cooker|"
        "cooking stove"
    ),
    "fridge": (
        "icebox|freezer|fridge freezer|cooling cabinet|ice box|cold cabinet|refrigeration unit|kitchen fridge|"
        "freezer cabinet|refrigerating cabinet"
    ),
    "kitchen_island": (
        "island|island unit|cooking island|kitchen block|center island|island bench|island table|central counter|"
        "middle counter|kitchen isle|central island|counter island|island in the kitchen"
    ),
    "dishwasher": "machine for dishes|dish machine|dish cleaning machine|dish cleaner",
    "washing_machine": "laundry machine|front loader|machine for laundry|clothes washing machine",
    "tall_cupboard": (
        "larder|tall cabinet|kitchen cabinet|high cabinet|storeroom|food store|food cabinet|provisions cabinet"
    ),
    "breakfast_table": (
        "small kitchen table|kitchen table|round kitchen table|cafe table|small dining table|coffee house table|"
        "morning table|café table|breakfast nook table|tavern table|restaurant table|brunch table"
    ),
    "kitchen_trolley": "trolley|drinks trolley|hostess trolley",
    "pallet_rack": (
        "warehouse rack|high rack|pallet shelving|industrial rack|warehouse shelving|pallet storage|racking|rack|"
        "industrial racking|high bay rack|warehouse racking|goods rack"
    ),
    "shelving_unit": "shelving|utility shelving|wire shelving|garage shelving",
    "workbench": (
        "carpenter's bench|tool bench|workshop bench|joiner's bench|workshop table|craftsman's table|craft table|"
        "working table|working bench|carpenter's table|tool table|repair table"
    ),
    "packing_table": (
        "packaging table|packing bench|packing desk|wrapping table|shipping table|packing counter|"
        "table for packing|dispatch table"
    ),
    "pallet": (
        "wood pallet|euro pallet|shipping pallet|freight pallet|cargo pallet|transport pallet|loading pallet|"
        "timber pallet|goods pallet|platform of wood|forklift pallet"
    ),
    "pallet_stack": (
        "stacked pallets|pallet stack|pallet pile|heap of pallets|pallets|stack of wooden pallets|"
        "pallets on top of each other|many pallets|column of pallets|piled pallets"
    ),
    "conveyor": "conveyer|assembly line|roller track|conveyor line|production line",
    "forklift": "stacker|lifter",
    "crate_stack": (
        "stacked crates|crate stack|crate pile|crates|heap of crates|boxes stacked|stack of boxes|piled crates|"
        "many crates|column of crates"
    ),
    "barrel_group": "drums|couple of drums|twin drums",
    "tool_cabinet": (
        "tool chest|tool trolley|rolling tool chest|workshop cabinet|tool storage cabinet|mechanic's cabinet|"
        "tool locker|roller tool chest|wheeled tool cabinet|roll cabinet|rollaway|cabinet on rollers|"
        "cabinet on wheels|cabinet with tools|rolling cabinet"
    ),
    "platform_trolley": "flatbed trolley|dolly|transport trolley|flatbed wagon|pushcart|warehouse trolley",
    "locker": "lockers|changing room locker|staff locker|gym locker|storage locker|iron locker",
    "ladder": (
        "step ladder|folding ladder|steps|aluminium ladder|household ladder|extension ladder|climbing ladder|"
        "pair of steps|stepping ladder"
    ),
    "traffic_cone": (
        "cone|road cone|orange cone|warning cone|pylon|construction cone|marker cone|hazard cone|plastic cone|"
        "cone for traffic|street cone"
    ),
}
"""Kind of furniture (`hv_sim.furniture.FURNITURE_KINDS`) -> more words for it."""
COLORS: dict[str, str] = {
    "red": "scarlet|crimson|bright red|cherry red|ruby|blood red",
    "orange": "bright orange|tangerine|pumpkin|orange-coloured|carrot",
    "yellow": "lemon yellow|bright yellow|mustard|golden|canary yellow",
    "green": "dark green|olive|forest green|bright green|grass green|emerald",
    "teal": "turquoise|aquamarine|cyan|blue-green|petrol blue",
    "blue": "bright blue|sky blue|light blue|royal blue|cobalt|azure",
    "navy": "midnight blue|deep blue|ink blue|marine blue|indigo|very dark blue",
    "purple": "lilac|lavender|mauve|plum|magenta|aubergine",
    "pink": "rose|rosy|hot pink|fuchsia|salmon pink",
    "brown": "chocolate|chestnut|coffee-coloured|chocolate brown|brownish",
    "tan": "caramel|fawn|khaki|camel|pale brown|light chocolate",
    "beige": "ecru|buff|beigy|oatmeal|pale beige",
    "cream": "ivory|off-white|eggshell|vanilla|creamy|ivory-coloured",
    "white": "snow white|pure white|whitish|bright white|milky",
    "silver": "metallic|chrome|shiny gray|aluminium|steel-coloured|metal-coloured",
    "gray": "ash gray|light gray|mouse-coloured|stone gray|ashen|grayish",
    "charcoal": "anthracite|slate|graphite|blackish gray|slate gray|deep gray|soot",
    "black": "jet black|pitch black|ebony|inky|coal black|blackish",
    "terracotta": "rust-coloured|rusty|clay-coloured|reddish brown|burnt orange|rust red",
    "oak": "light wood|blond wood|honey-coloured wood|bright wood|oak|oaken|birch|pine",
    "walnut": "brown wood|mahogany|deep brown wood|wenge|walnut wood|stained wood",
}
"""Colour (`hv_sim.lexicon.COLOR_WORDS`) -> more words for it."""
SIZES: dict[str, str] = {
    "small": "tiny|mini|smaller|smallest|compact|petite|smallish|short",
    "large": "huge|larger|largest|oversized|bulky|giant|great|tall",
}
"""Size (`hv_sim.lexicon.SIZE_WORDS`) -> more words for it."""
