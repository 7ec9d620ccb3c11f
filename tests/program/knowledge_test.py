"""Priors, numbers that follow others and constraints as a user meets them."""
import pytest

from support import *

folder = workspace()
WEIGHTED = STUDY.replace('misfit = "log"', 'misfit = "weighted"\nnoise_relative = 0.02')


def fit(label, text, *options):
    done = run("fit", write_study(folder / label, text), "--json", "--out", folder / label / "out", "--explore", 32,
               "--starts", 4, "--joint-only", *options)
    assert done.returncode == 0, f"{label}: {done.stderr}"
    return json.loads(done.stdout)


def after(name, addition):
    """The study with a line more in the table of that parameter."""
    assert f'name = "{name}"\n' in WEIGHTED, f"the study varies {name}"
    return WEIGHTED.replace(f'name = "{name}"\n', f'name = "{name}"\n{addition}\n')


@pytest.fixture(scope="module")
def free():
    return fit("free", WEIGHTED)


@pytest.fixture(scope="module")
def answer(free):
    k1 = free["best"]["parameters"]["base.k1"]
    error = free["best"]["standard_errors"]["base.k1"]
    return k1, error


def test_a_sure_prior_decides_and_a_vague_one_does_not(free, answer):
    k1, error = answer
    # A prior that is much surer than the readings decides; one that is much less sure changes next to nothing.
    sure = fit("sure", after("base.k1", f"prior = {{ mean = {1.5 * k1}, sd = 1e-4 }}"))
    assert abs(sure["best"]["parameters"]["base.k1"] / (1.5 * k1) - 1) < 0.01, "a sure prior decides"
    prior = next(p for p in sure["priors"]["parameters"] if p["name"] == "base.k1")
    assert prior["share"] > 0.99, f"nearly all that is known of it is the prior's: {prior['share']}"
    assert abs(sure["noise"]["chi2"] / free["noise"]["chi2"] - 1) < 1e-2, f"the readings alone judge their noise: {sure['noise']} {free['noise']}"
    assert sure["priors"]["p_value"] < 1e-4 or sure["priors"]["degrees_of_freedom"] == 0, f"and contradict that prior: {sure['priors']['p_value']}"
    assert not any("stands out" in f or f.startswith("The model does not fit") for f in sure["findings"]), \
        f"neither a reading nor the model is blamed: {sure['findings']}"
    vague = fit("vague", after("base.k1", f"prior = {{ mean = {k1}, sd = 8.0 }}"))
    assert abs(vague["best"]["parameters"]["base.k1"] - k1) < 0.05 * error, "a vague prior changes nothing"
    assert all(p["share"] < 0.05 for p in vague["priors"]["parameters"]), "and tells nothing"


def test_what_the_readings_alone_want_is_the_fit_without_priors(answer):
    k1, _ = answer
    # The readings' own answer and the prior's, far apart.
    far = fit("far", after("base.k1", f"prior = {{ mean = {k1 * 2.5}, sd = 0.02 }}"))
    if far["priors"]["degrees_of_freedom"] > 0:
        wants = next(p for p in far["priors"]["parameters"] if p["name"] == "base.k1")["readings_want"]
        assert abs(wants / k1 - 1) < 0.05, f"what the readings alone call for is the fit without priors: {wants} against {k1}"


def test_a_tie_is_the_study_with_that_number_written_out():
    tied = fit("tied", WEIGHTED + '\n[[parameters]]\nname = "asphalt.modulus_MPa"\nequals = "1.5 * base.k1"\n')
    best = tied["best"]["parameters"]
    text = WEIGHTED.replace("modulus_MPa = 3000", f"modulus_MPa = {1.5 * best['base.k1']}").replace("k1 = 2000", f"k1 = {best['base.k1']}")
    text = text.replace("n = 0.5\n", f"n = {best['base.n']}\n") + f"\n[solver]\nload_steps = {tied['path']['load_steps']}\n" # the fit's
    written = run("forward", write_study(folder / "written", text), "--json")
    values = [[r["value"] for r in responses] for responses in (tied["responses"], json.loads(written.stdout)["responses"])]
    assert max(abs(a / b - 1) for a, b in zip(*values)) < 1e-9, f"tied and written out are the same section: {values}"


def test_a_constraint_that_holds_the_answer_back_is_named(free, answer):
    k1, _ = answer
    # A constraint that the readings press against holds, and is named.
    limit = 0.7 * k1
    held = fit("held", WEIGHTED + f'\n[[constraints]]\nthat = "base.k1 <= {limit}"\n')
    assert held["constraints"][0]["active"], "it holds the answer back"
    assert abs(held["best"]["parameters"]["base.k1"] / limit - 1) < 2e-3, "the answer lies on it"
    assert any("active" in f and "base.k1 <=" in f for f in held["findings"]), "and the page names it"
    assert abs(held["noise"]["chi2"] / free["noise"]["chi2"] - 1) < 1e-2, "what the constraint costs is not the readings' noise"
    for method in ("slsqp", "cobyla"):
        other = fit(method, WEIGHTED + f'\n[[constraints]]\nthat = "base.k1 <= {limit}"\n', "--method", method)
        assert abs(other["best"]["misfit"] / held["best"]["misfit"] - 1) < 1e-3, f"{method} ends in the same minimum as Gauss-Newton"
    loose = fit("loose", WEIGHTED + f'\n[[constraints]]\nthat = "base.k1 >= 0"\n')
    assert not loose["constraints"][0]["active"] and abs(loose["best"]["parameters"]["base.k1"] / k1 - 1) < 1e-3, "one that is met anyway changes nothing"


def test_a_constraint_on_an_output_goes_through_every_command(free):
    output = '\n[[outputs]]\nname = "ez"\nload = "fwd"\nquantity = "strain_zz"\nx_mm = 0\ndepth_mm = 300\ngauge_mm = 75\n'
    text = WEIGHTED + output + '\n[[constraints]]\nthat = "ez <= 100000"\n'
    held = fit("output", text)
    assert abs(held["best"]["parameters"]["base.k1"] / free["best"]["parameters"]["base.k1"] - 1) < 1e-3, "one that is met changes nothing"
    path = write_study(folder, text, name="ez")
    for command, *options in (("unique", "--explore", 8, "--verify", 2), ("sample", "--samples", 400)):
        done = run(command, path, *options, "--threads", 1, "--json", "--out", folder / f"ez-{command}")
        assert done.returncode in (0, 1) and done.stdout.startswith("{"), done.stderr


# Student's noise: one reading three times as large as it is, which normal noise follows.
NOISE = '\n[data.noise]\nrelative = 0.02\n{}\n'


def with_noise(more):
    return WEIGHTED.replace("noise_relative = 0.02", NOISE.format(more), 1)


def spoilt(row):
    """The data with the value of one reading wrong."""
    lines = DATA.splitlines()
    cells = lines[row].split(",")
    at = lines[1].split(",").index("value")
    cells[at] = str(3.0 * float(cells[at]))
    lines[row] = ",".join(cells)
    return "\n".join(lines) + "\n"


def fitted(label, text, data):
    done = run("fit", write_study(folder / label, text, data), "--json", "--out", folder / label / "out", "--explore", 32,
               "--starts", 4, "--joint-only")
    assert done.returncode == 0, f"{label}: {done.stderr}"
    return json.loads(done.stdout)


student = 'loss = "student"\ndegrees = 4'


@pytest.fixture(scope="module")
def robust():
    return fitted("robust", with_noise(student), spoilt(3))


def test_students_noise_keeps_a_wrong_reading_from_the_answer(answer, robust):
    k1, _ = answer
    weights = [r["weight"] for r in robust["responses"] if "weight" in r]
    assert len(weights) == robust["readings"], "every reading has a weight"
    assert min(weights) == weights[1] < 0.1, f"the wrong reading has the lowest: {weights}"
    assert any("less than half" in f and "normal noise" in f for f in robust["findings"]), f"a finding names it: {robust['findings']}"
    assert robust["noise"]["loss"] == "student" and robust["noise"]["expected_chi2"] > robust["noise"]["degrees_of_freedom"], \
        "what is expected of Student's rows is simulated"
    normal = fitted("normal", with_noise(""), spoilt(3))
    off = [abs(f["best"]["parameters"]["base.k1"] / k1 - 1) for f in (robust, normal)]
    assert off[0] < off[1], f"the answer stays nearer to that of the clean readings: {off}"
    # By the definition of the weight, with what `fit` itself says of the residual.
    for r in robust["responses"]:
        if "weight" in r:
            assert abs(r["weight"] - 5 / (4 + r["residual"] ** 2)) < 1e-9, f"weight {r['weight']} of residual {r['residual']}"


def refused(label, words, text, *command):
    case = folder / ("refused " + label)
    done = run(*(command or ("fit",)), write_study(case, text), "--out", case / "out")
    message = done.stderr.strip()
    print(f"{label}\n    {message.replace(str(case), '...')}")
    assert done.returncode == 2 and done.stdout == "" and len(message.splitlines()) == 1, f"{label}: {done.returncode} {message}"
    assert not (case / "out").exists(), f"{label}: something was written"
    for word in words:
        assert word in message, f"{label}: '{word}' is missing"


TIE = '\n[[parameters]]\nname = "{}"\nequals = "{}"\n'
LIMIT = '\n[[constraints]]\nthat = "{}"\n'


@cases(
    case("prior outside its range", ["prior", "mean", "99990"], after("base.k1", "prior = { mean = 99990, sd = 0.1 }")),
    case("prior without spread", ["sd", "0 < value"], after("base.k1", "prior = { mean = 1000, sd = 0 }")),
    case("prior with another key", ["median", "mean"], after("base.k1", "prior = { mean = 1000, median = 3, sd = 0.1 }")),
    case("prior and no stated noise", ["prior", "noise"], after("base.k1", "prior = { mean = 1000, sd = 0.1 }").replace("noise_relative = 0.02", "")),
    case("expression that reads itself", ["reads the number it sets"], WEIGHTED + TIE.format("base.k2", "2 * base.k2")),
    case("unknown loss", ["loss", "huber", "student"], with_noise('loss = "huber"')),
    case("no degrees", ["degrees", "1 <= value"], with_noise('loss = "student"\ndegrees = 0.5')),
    case("degrees of a normal loss", ["degrees", "student"], with_noise("degrees = 4")),
    case("student and another misfit", ["loss", "weighted"], with_noise(student).replace('misfit = "weighted"', 'misfit = "log"')),
    case("student and no stated noise", ["loss", "stated"], with_noise(student).replace("relative = 0.02", "")),
    case("student and diagnose", ["loss", "normal"], with_noise(student), "diagnose"),
)
def test_wrong_knowledge_is_one_message(arguments, options):
    refused(*arguments, **options)


# Both parameters have a prior, whose errors are tied.
BOTH = after("base.k1", "prior = { mean = 2000, sd = 0.3 }").replace('name = "base.n"\n', 'name = "base.n"\nprior = { mean = 0.5, sd = 0.2 }\n')
TIED = '\n[[prior_correlations]]\nbetween = {}\nvalue = {}\n'


def test_correlated_priors_count():
    untied = fit("untied", BOTH)
    null = fit("null", BOTH + TIED.format('["base.k1", "base.n"]', 0))
    assert untied["best"]["parameters"] == null["best"]["parameters"], "a correlation of 0 changes no bit"
    tied_priors = fit("tied priors", BOTH + TIED.format('["base.n", "base.k1"]', -0.9))
    pulls = [next(p["pull"] for p in tied_priors["priors"]["parameters"] if p["name"] == name) for name in ("base.k1", "base.n")]
    assert untied["best"]["parameters"] != tied_priors["best"]["parameters"], f"one of -0.9 does: {pulls}"


@cases(
    case("correlation without a prior", ["base.k2", "prior"], BOTH + TIED.format('["base.k1", "base.k2"]', 0.5)),
    case("correlation with itself", ["two parameters"], BOTH + TIED.format('["base.k1", "base.k1"]', 0.5)),
    case("correlation of three", ["two parameters"], BOTH + TIED.format('["base.k1", "base.n", "base.k2"]', 0.5)),
    case("correlation beyond 1", ["value", "1"], BOTH + TIED.format('["base.k1", "base.n"]', 1.5)),
    case("correlation of 1", ["positive definite"], BOTH + TIED.format('["base.k1", "base.n"]', 1.0)),
    case("correlation that appears twice", ["twice"], BOTH + 2 * TIED.format('["base.k1", "base.n"]', 0.5)),
    case("expressions in a circle", ["reads the number it sets"],
         WEIGHTED + TIE.format("base.k2", "-base.k3") + TIE.format("base.k3", "-base.k2")),
    case("unknown name", ["base.k7", "no known name"], WEIGHTED + TIE.format("base.k2", "0.1 * base.k7")),
    case("expression and bounds", ["min", "name and equals alone"], WEIGHTED + TIE.format("base.k2", "0.5") + "min = 0.1\n"),
    case("searched and tied", ["is given twice"], WEIGHTED + TIE.format("base.k1", "1000")),
    case("out of its range", ["out of range", "base.poisson_12"], WEIGHTED + TIE.format("base.poisson_12", "9")),
    case("constraint without a relation", ["<=", "two sides"], WEIGHTED + LIMIT.format("base.k1 < 5")),
    case("constraint with an unknown name", ["base.k7", "no known name"], WEIGHTED + LIMIT.format("base.k7 <= 5")),
)
def test_wrong_correlations_and_expressions_are_one_message(arguments, options):
    refused(*arguments, **options)


def test_constraints_that_no_point_meets_are_named():
    IMPOSSIBLE = WEIGHTED + '\n[[outputs]]\nname = "top"\nload = "fwd"\nquantity = "strain_zz"\ndepth_mm = 350\n' + LIMIT.format("top >= 100000")
    for command in ("fit", "unique"):
        done = run(command, write_study(folder / f"impossible-{command}", IMPOSSIBLE), "--out", folder / f"impossible-{command}" / "out", "--explore", 16)
        assert done.returncode == 1 and "top >= 100000" in done.stderr, f"{command}: no point meets a constraint on an output: {done.returncode} {done.stderr}"
    done = run("fit", write_study(folder / "nowhere", WEIGHTED + LIMIT.format("ln(1 - base.k1) >= 0")), "--out", folder / "nowhere" / "out", "--explore", 16)
    assert done.returncode == 1 and "ln(1 - base.k1) >= 0" in done.stderr, f"a constraint without a value is named: {done.stderr}"


def test_noise_of_every_shape_goes_through_the_commands():
    for i, shape in enumerate(("common_relative = 0.01", "correlation_mm = 600", 'loss = "student"')):
        text = WEIGHTED.replace('misfit = "weighted"\nnoise_relative = 0.02', f'misfit = "weighted"\n[data.noise]\nrelative = 0.02\n{shape}')
        study = write_study(folder / f"shape-{i}", text)
        for command in ("unique", "diagnose")[:1 if "student" in shape else 2]:
            done = run(command, study, "--out", folder / f"shape-{i}" / command, "--explore", 16,
                       *(("--verify", 2) if command == "unique" else ("--starts", 2, "--bootstrap", 2)))
            assert done.returncode == 0, f"{command} with {shape}: {done.stderr}"


@pytest.mark.long
def test_sample_takes_priors_and_constraints(answer):
    k1, _ = answer
    for name, text in (("prior", after("base.k1", f"prior = {{ mean = {k1}, sd = 0.1 }}")), ("constraint", WEIGHTED + LIMIT.format(f"base.k1 <= {k1}"))):
        done = run("sample", write_study(folder / f"sample-{name}", text), "--out", folder / f"sample-{name}" / "out", "--samples", 400, "--model", "reduced")
        assert done.returncode in (0, 1) and "Segmentation" not in done.stderr and "Posterior" in done.stdout, \
            f"sample with a {name}: {done.returncode} {done.stderr}"


@cases(
    case("sd in the unit of a logarithmic axis", ["natural logarithm", "600"], after("base.k1", "prior = { mean = 2000, sd = 600 }")),
    case("contradiction", ["contradict each other", "base.k1 <= 1000", "base.k1 >= 2000"],
         WEIGHTED + LIMIT.format("base.k1 <= 1000") + LIMIT.format("base.k1 >= 2000")),
    case("against the bounds", ["cannot be met", "base.k1 >= 90000"], WEIGHTED + LIMIT.format("base.k1 >= 90000")),
)
def test_what_contradicts_itself_is_one_message(arguments, options):
    refused(*arguments, **options)
