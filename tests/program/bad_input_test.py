"""Wrong input: one clear message with file, line, key, what was found, what is allowed; exit status 2; nothing written."""
from support import *

folder = workspace()


def expect(label, words, study=STUDY, data=DATA, command=("map",), line=None, file=None):
    case = folder / label.replace(" ", "-")
    path = write_study(case, study, data)
    out = case / "out"
    done = run(*command, path, "--out", out)
    message = done.stderr.strip()
    print(f"{label}\n    {message.replace(str(case), '...')}")
    assert done.returncode == 2, f"{label}: exit status {done.returncode}"
    assert len(message.splitlines()) == 1, f"{label}: one message, not {len(message.splitlines())}"
    assert done.stdout == "", f"{label}: standard output is not empty"
    assert not out.exists(), f"{label}: something was written"
    for word in words:
        assert word in message, f"{label}: '{word}' is missing"
    if line is not None:
        text = study if file is None else data
        number = next(i for i, content in enumerate(text.splitlines(), 1) if line in content)
        assert f"{file or 'small.toml'}:{number}:" in message, f"{label}: line {number} is not named"


def changed(old, new):
    assert STUDY.count(old) >= 1, f"the study holds '{old}'"
    return STUDY.replace(old, new, 1)


OUTPUT_AGAIN = STUDY[STUDY.index("[[outputs]]"):]
RELAXING = STUDY.replace('law = "linear"\nmodulus_MPa = 3000', 'law = "viscoelastic"\nmodulus_MPa = 9000\ng1 = 0.5\ntau1_s = 0.01', 1)
CORRECTION = '[[corrections]]\nchannel = "depth"\nlayer = "base"\nat_mm = [0, 100, 250]\nfactor = [1.0, 0.5, 1.2]\n\n[[outputs]]'


def correcting(old, new):
    assert CORRECTION.count(old) == 1, old
    return changed("[[outputs]]", CORRECTION.replace(old, new))


@cases(
    # The ten kinds.
    case("unknown key", ["thicknes_mm", "thickness_mm", "asphalt"], changed("thickness_mm = 40", "thicknes_mm = 40"),
         line="thicknes_mm"),
    case("wrong unit", ["unit", "kPa", "mm, um"], data=DATA.replace("0.95,mm", "0.95,kPa"), line="0.95", file="small.csv"),
    case("missing file", ["small.csv", "does not exist"], data=None, line="files ="),
    *(case(f"a file outside {outside.replace('/', '-')}", ["outside", outside, "outside = true"], changed('"small.csv"', f'"{outside}"'), line="files =")
      for outside in ("../small.csv", "/etc/passwd", "a/../../small.csv")),
    case("a file outside with leave", ["does not exist"], changed('files = ["small.csv"]', 'files = ["../nowhere.csv"]\noutside = true'), line="files ="),
    case("bounds swapped", ["base.k1", "min = 8000, max = 500", "min < max"],
         changed("min = 500\nmax = 8000", "min = 8000\nmax = 500"), line="min = 8000"),
    case("thickness not positive", ["thickness_mm", "0 < value"], changed("thickness_mm = 250", "thickness_mm = 0"),
         line="thickness_mm = 0"),
    case("nan in the data", ["value", "nan", "finite"], data=DATA.replace("0.95", "nan"), line="nan", file="small.csv"),
    case("sensor outside the mesh", ["outside the mesh", "extent_m", "3.5 m"], data=DATA.replace("fwd,deflection,600", "fwd,deflection,3500"),
         line="3500", file="small.csv"),
    case("parameter that names nothing", ["base.k4", "base.k1"], changed('name = "base.k1"', 'name = "base.k4"'), line="base.k4"),
    case("impossible Poisson ratios", ["base", "n = 4", "1 - nu12 - 2 n nu31^2"], changed("n = 0.5\n", "n = 4.0\n"), line=None),
    case("more than all of a modulus fades", ["asphalt", "g1 = 0.5", "g2 = 0.6", "add up to 1.1"], RELAXING.replace("g1 = 0.5", "g1 = 0.5\ng2 = 0.6")),
    case("relaxation and the secant law", ["relaxes", "secant", "incremental"], RELAXING.replace("[mesh]", '[solver]\nintegration = "secant"\n\n[mesh]'),
         line="integration ="),
    case("empty data", ["no measurements"], data=DATA.splitlines()[0] + "\n" + DATA.splitlines()[1] + "\n"),
    case("correction by an unknown channel", ["detph", "did you mean \"depth\"", "distance"], correcting('"depth"', '"detph"'), line="detph"),
    case("correction of no layer", ["not in the study", "bass", "asphalt"], correcting('"base"', '"bass"'), line="bass"),
    case("factors for other places", ["base-depth", "3 places, 2 factors"], correcting(", 1.2]", "]"), line="factor = [1.0, 0.5]"),
    case("places that do not rise", ["base-depth", "rise", "100, 50"], correcting("250]", "50]"), line="at_mm"),
    case("a factor of nothing", ["base-depth", "out of range", "0 < value"], correcting("0.5", "0"), line="factor ="),
    case("depths as stresses", ["base-depth", "at_mm", "missing"], correcting("at_mm", "at_kPa")),
    case("theta of zero", ["base-theta", "logarithm", "above 0"], correcting('"depth"', '"theta"').replace("at_mm", "at_kPa"), line="at_kPa"),
    case("output twice", ["two outputs have this name", "subgrade-top-strain"], STUDY + OUTPUT_AGAIN),
    case("correction twice", ["base-depth", "twice"], changed("[[outputs]]", CORRECTION.replace("[[outputs]]", CORRECTION))),
    case("factor that there is not", ["base-depth.factor_4", "base-depth.factor_3"],
         changed("[[outputs]]", CORRECTION.replace("[[outputs]]", '[[parameters]]\nname = "base-depth.factor_4"\nmin = 0.1\nmax = 2\n\n[[outputs]]')), line="factor_4"),
    # And more that happen.
    case("unknown column", ["unknown column", "depth"], data=DATA.replace("depth_mm", "depth")),
    case("too few cells", ["cells", "8"], data=DATA.replace("0.95,mm,", "0.95,mm"), line="0.95", file="small.csv"),
    case("not a number", ["wrong type", "a number"], changed("k1 = 2000", 'k1 = "2000"'), line='k1 = "2000"'),
    case("missing key", ["k2", "this key is missing"], changed("k2 = 0.5\n", "")),
    case("unknown law", ["uzann", "did you mean \"uzan\"", "linear"], changed('law = "uzan"', 'law = "uzann"'), line="uzann"),
    case("not TOML", ["not valid TOML"], changed("[mesh]", "[mesh"), line="[mesh"),
    case("unknown load in the data", ["this load is not in the study", "fwd"], data=DATA.replace("fwd,strain_zz", "fdw,strain_zz"),
         line="fdw", file="small.csv"),
    case("negative sigma", ["sigma", "positive"], data=DATA.replace("0.95,mm,", "0.95,mm,-1"), line="0.95", file="small.csv"),
    case("gauge where there is none", ["gauge length"], data=DATA.replace("600,0,0,0", "600,0,0,75").replace("deflection,600", "strain_xx,600").replace("0.21,mm", "210,microstrain")),
    case("log of a parameter that may be zero", ["base.k3", "value out of range"],
         changed('name = "base.n"\nmin = 0.1\nmax = 4.5', 'name = "base.k3"\nmin = -1\nmax = -0.1\nscale = "log"')),
    case("overlapping patches of a dual", ["spacing_mm", "overlap", "at least the width"],
         changed('type = "plate"\nradius_mm = 150', 'type = "dual-wheel"\nforce_kN = 40\nspacing_mm = 150')),
    case("no parameters", ["parameters"], STUDY[:STUDY.index("[[parameters]]")], command=("fit",)),
    case("unknown schema", ["schema"], changed("schema = 1", "schema = 2"), line="schema"),
    case("two layers of one name", ["base", "each name once"], changed('name = "subgrade"', 'name = "base"')),
)
def test_wrong_input_is_one_message_that_names_its_place(arguments, options):
    expect(*arguments, **options)


def test_wrong_arguments_end_with_status_2():
    for arguments in (["map"], ["nonsense"], ["map", "x.toml", "--threads", "0"], ["map", "x.toml", "--nonsense"], []):
        assert run(*arguments).returncode == 2, f"exit status of {arguments}"


def test_what_is_not_there_is_named():
    done = run("map", folder / "nowhere.toml")
    assert done.returncode == 2 and "nowhere.toml" in done.stderr, "a study that is not there"
    done = run("export", folder / "nowhere")
    assert done.returncode == 2 and "no run here" in done.stderr, "a run that is not there"
