#include "support/ledgers.h"

namespace ledgers {

// 40 degrees of freedom: p = 0.05 at 55.8, 0.005 at 66.8. Weights are logarithms.
std::vector<Case> table() {
    const Row bad = nothing(120, -60);
    const Row far = noise(1.73, -30);
    Row rise = fitted(Kind::layout, "sensors 3 and 4 exchanged", 0, 0, 0);
    rise.is_premise = true;
    rise.hypothesis.terms = {{"sensor-position", "", "readings"}};
    rise.not_tried = "seen in the readings";
    Row untried = fitted(Kind::effect, "c", 0, 1, 0);
    untried.not_tried = "not among those that promise most";
    Row on_coarse = effect("a", 30, -10);
    on_coarse.fit.mesh = diagnose::Mesh::coarse;
    std::vector<Case> list;
    const auto add = [&](Case c) -> Case& { return list.emplace_back(std::move(c)); };
    // Nothing is wrong.
    add({"noise as stated", {nothing(40, 0)}, Verdict::adequate}).score = 0.4;
    add({"an effect that gains by chance", {nothing(45, 0), effect("a", 41, -3)}, Verdict::adequate}).score = 0.4;
    add({"even one that is more probable", {nothing(52, 0), effect("a", 41, 2)}, Verdict::adequate}).score = 0.02;
    add({"noise of another size", {nothing(90, -45), noise(1.5, -30), effect("a", 80, -34)}, Verdict::adequate});
    add({"errors that readings share",
         {bad, noise(1.7, -30), noise(1.0, -12, "shared"), effect("a", 60, -20)},
         Verdict::adequate});
    add({"noise of several kinds, together",
         {nothing(80, -33), noise(1.4, -32), noise(1.0, -32.5, "alike"), effect("a", 60, -31.9)},
         Verdict::adequate});
    add({"one score stood out, no fit bears it out", {nothing(50, 0), effect("a", 44, -2)}, Verdict::adequate});
    add({"noise far larger is no explanation",
         {nothing(400, -200), noise(3.1, -60)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"nor is noise with a pattern",
         {with_pattern(nothing(90, -45), 40, 4), with_pattern(noise(1.5, -30), 40, 4)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"a pattern that the larger noise makes",
         {with_pattern(nothing(90, -45), 20, 4), with_pattern(noise(1.5, -30), 20, 4)},
         Verdict::adequate});
    // Names.
    add({"one effect", {bad, far, effect("a", 38, -10)}, Verdict::cause_named, {"a"}});
    add({"one that leaves a little more, beside noise that is less probable",
         {bad, noise(1.3, -11.7), effect("a", 58, -10)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise});
    add({"and beside noise that is nearly as probable",
         {bad, noise(1.3, -10.7), effect("a", 58, -10)},
         Verdict::unexplained,
         {},
         Reason::noise});
    add({"one effect far before another",
         {bad, far, effect("a", 38, -10), effect("b", 52, -16)},
         Verdict::cause_named,
         {"a"}});
    add({"another one nearly as probable",
         {bad, far, effect("a", 38, -10), effect("b", 42, -12)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::several_names});
    add({"the other leaves more than noise",
         {bad, far, effect("a", 38, -10), effect("b", 70, -12)},
         Verdict::cause_named,
         {"a"}});
    add({"what readings cannot tell apart",
         {bad, far, effect("a", 38, -10), effect("b", 52, -16)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::several_names})
        .confounded = {{"effect: a", "effect: b", 0.8}};
    add({"unless they reject it by far",
         {bad, far, effect("a", 38, -10), effect("b", 80, -30)},
         Verdict::cause_named,
         {"a"}})
        .confounded = {{"effect: a", "effect: b", 0.8}};
    add({"variants of one effect are one name",
         {bad, far, effect("a", 38, -10),
          [] {
              Row r = effect("a", 39, -10.5);
              r.hypothesis.name = "a (other)";
              return r;
          }()},
         Verdict::cause_named,
         {"a"}});
    add({"an effect or larger noise, which is more probable",
         {nothing(75, -32), noise(1.37, -26), effect("a", 50, -26.2), effect("b", 60, -26.5)},
         Verdict::unexplained,
         {},
         Reason::noise});
    add({"a name that leaves noise stays beside less probable noise",
         {nothing(75, -32), noise(1.37, -28), effect("a", 50, -26)},
         Verdict::ambiguous,
         {"a"},
         Reason::noise});
    add({"names count together",
         {nothing(75, -32), noise(1.37, -26), effect("a", 50, -26.2), effect("b", 52, -26.4)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::several_names});
    add({"larger noise is hardly possible",
         {nothing(75, -32), noise(1.37, -28.6), effect("a", 50, -26)},
         Verdict::ambiguous,
         {"a"},
         Reason::noise});
    Row shared = noise(1.0, -28, "shared");
    shared.is_independent = false;
    Row tails = noise(1.0, -14.0, "tails");
    tails.has_tails = true;
    add({"wrong readings, whether their errors have heavy tails or not",
         {bad, far, tails, wrong_readings({"7", "9"}, 40, -12)},
         Verdict::cause_named,
         {"outlier"}});
    add({"which an effect would have to be told from",
         {bad, far, tails, effect("a", 40, -12)},
         Verdict::ambiguous,
         {"a"},
         Reason::noise});
    Row much_shared = noise(1.6, -12, "shared");
    much_shared.is_independent = false;
    add({"errors that readings share are no excuse for larger ones beside them",
         {bad, far, much_shared, effect("a", 90, -25)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    much_shared.noise = 1.4;
    Row far_tails = noise(2.0, -12, "tails");
    far_tails.has_tails = true;
    add({"nor are heavy tails",
         {bad, far, far_tails, effect("a", 90, -25)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"unless they are little larger", {bad, far, much_shared, effect("a", 90, -25)}, Verdict::adequate});
    add({"an effect or errors that readings share",
         {nothing(75, -40), shared, effect("a", 50, -26)},
         Verdict::ambiguous,
         {"a"},
         Reason::noise});
    add({"the end of a range within the interval",
         {bad, far, at_end(effect("a", 38, -10))},
         Verdict::ambiguous,
         {"a"},
         Reason::at_end});
    add({"evidence that chance makes in 3 % of cases",
         {bad, far, effect("a", 38, -10)},
         Verdict::ambiguous,
         {"a"},
         Reason::weak_evidence})
        .chances = {{"effect: a", 0.03}};
    add({"in 20 % of cases", {bad, far, effect("a", 38, -10)}, Verdict::unexplained, {}, Reason::weak_evidence})
        .chances = {{"effect: a", 0.2}};
    add({"a little more than noise is left, and next to nothing else is probable", // p = 0.017
         {bad, far, effect("a", 60, -14)},
         Verdict::cause_named,
         {"a"}});
    add({"more than noise is left", // p = 0.0045
         {bad, far, effect("a", 66, -14)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise});
    add({"a little more, and something else has a tenth of the probability",
         {bad, far, effect("a", 60, -14), correction(70, -16)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise});
    add({"then what is as near stands beside it",
         {bad, far, effect("a", 60, -14), effect("b", 68, -16)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::leaves_more_than_noise});
    add({"far more than noise is left",
         {bad, far, effect("a", 90, -20)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"one rejected by little that has nearly all of the probability", // p = 0.0035
         {bad, far, effect("a", 67, -14)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise});
    add({"but not half of it",
         {bad, noise(3.1, -14), effect("a", 67, -14)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"a rejected one does not lead",
         {bad, far, effect("a", 70, -14), effect("b", 52, -20)},
         Verdict::ambiguous,
         {"b", "a"},
         Reason::several_names});
    add({"two together, none alone",
         {bad, far, effect("a", 90, -25), two("a", "b", 38, -12)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::two_effects});
    add({"one that leaves noise does not vanish for two",
         {bad, far, effect("a", 54, -20), two("c", "b", 36, -12)},
         Verdict::ambiguous,
         {"c", "b", "a"},
         Reason::several_names});
    add({"of two the one that explains more alone comes first",
         {bad, far, effect("a", 90, -25), effect("b", 75, -22), two("a", "b", 38, -12)},
         Verdict::ambiguous,
         {"b", "a"},
         Reason::two_effects});
    add({"not fitted is not judged", {bad, far, effect("a", 38, -10), untried}, Verdict::cause_named, {"a"}});
    add({"the fit on the study's mesh counts",
         {bad, far, on_coarse, effect("a", 90, -20)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"nothing was tried", {bad, far}, Verdict::adequate});
    // Readings.
    add({"one wrong reading", {bad, far, wrong_readings({"7"}, 40, -12)}, Verdict::cause_named, {"outlier"}});
    add({"several wrong readings",
         {bad, far, wrong_readings({"7"}, 80, -25), wrong_readings({"7", "9"}, 40, -12)},
         Verdict::cause_named,
         {"outlier"}});
    add({"several are no less one explanation than an effect",
         {bad, far, wrong_readings({"7", "9"}, 40, -12), effect("a", 50, -13)},
         Verdict::ambiguous,
         {"outlier", "a"},
         Reason::several_names});
    add({"corrections that leave more do not displace them",
         {bad, far, wrong_readings({"7", "9"}, 40, -12), correction(45, -3, {"base"}, 9)},
         Verdict::cause_named,
         {"outlier"}});
    // Corrections.
    add({"no name, but a place", {bad, far, correction(42, -12)}, Verdict::located});
    add({"a name that is rejected, and a place",
         {bad, far, effect("a", 90, -25), correction(42, -12)},
         Verdict::located});
    add({"it suffices that places differ", {bad, far, effect("a", 90, -25), correction(42, -12)}, Verdict::located})
        .says = Says::between_places;
    add({"a place that is next to impossible beside a name that is rejected",
         {bad, far, effect("a", 80, -10), correction(50, -20)},
         Verdict::unexplained,
         {},
         Reason::nothing_explains});
    add({"no place is known",
         {bad, far, effect("a", 90, -25), correction(42, -12)},
         Verdict::unexplained,
         {},
         Reason::no_place})
        .says = Says::nothing;
    add({"what comes nearest gives way to a correction that comes nearer, though what was left out speaks against it",
         {bad, far, effect("a", 70, -20), correction(42, -12)},
         Verdict::unexplained,
         {},
         Reason::predicts_worse})
        .predicted = {{of_correction, 1.0, 2.0}};
    add({"what was left out speaks against it",
         {bad, far, correction(42, -12)},
         Verdict::unexplained,
         {},
         Reason::predicts_worse})
        .predicted = {{of_correction, 1.2, 1.6}};
    add({"or for it", {bad, far, correction(42, -12)}, Verdict::located}).predicted = {{of_correction, 1.6, 1.2}};
    add({"it is rejected itself", {bad, far, correction(95, -12)}, Verdict::unexplained, {}, Reason::nothing_explains});
    add({"or larger noise does as well",
         {nothing(75, -32), noise(1.37, -28), correction(45, -26)},
         Verdict::unexplained,
         {},
         Reason::noise});
    add({"a name that leaves noise stays",
         {bad, far, effect("a", 52, -16), correction(36, -8)},
         Verdict::ambiguous,
         {"a"},
         Reason::correction});
    add({"one that leaves more gives way", {bad, far, effect("a", 60, -16), correction(36, -8)}, Verdict::located});
    add({"but only for a place",
         {bad, far, effect("a", 60, -16), correction(36, -8)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise})
        .says = Says::between_places;
    add({"or where the name is next to impossible beside it", // 1 to 8,900
         {bad, far, effect("a", 60, -17.1), correction(36, -8)},
         Verdict::located})
        .says = Says::between_places;
    add({"wrong readings that leave noise and are next to impossible are no answer either",
         {bad, far, wrong_readings({"7", "9", "11"}, 45, -18), correction(36, -8)},
         Verdict::located})
        .says = Says::between_places;
    add({"an effect that leaves noise stays",
         {bad, far, effect("a", 45, -18), correction(36, -8)},
         Verdict::ambiguous,
         {"a"},
         Reason::correction})
        .says = Says::between_places;
    add({"though it says of one layer what the name says, for it leaves noise",
         {bad, far, effect("a", 60, -17.1, "base"), correction(36, -8, {"base"})},
         Verdict::located})
        .says = Says::between_places;
    add({"unless it says the same, and leaves more than noise, too",
         {bad, far, effect("a", 60, -17.1, "base"), correction(54, -8, {"base"})},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise})
        .says = Says::between_places;
    add({"what knows nothing of places explains nothing, and neither does such a name",
         {bad, far, effect("a", 60, -17.1), correction(36, -8)},
         Verdict::unexplained,
         {},
         Reason::no_place})
        .says = Says::nothing;
    add({"and for what is clearly more probable",
         {bad, far, effect("a", 60, -10), correction(50, -8)},
         Verdict::ambiguous,
         {"a"},
         Reason::leaves_more_than_noise});
    add({"one that leaves noise, though less probable, keeps it from that",
         {bad, far, effect("a", 60, -16), effect("b", 54, -22), correction(36, -8)},
         Verdict::ambiguous,
         {"a", "b"},
         Reason::leaves_more_than_noise});
    add({"a rival",
         {bad, far, effect("a", 38, -10), correction(37, -11)},
         Verdict::ambiguous,
         {"a"},
         Reason::correction});
    add({"that knows no place is none",
         {bad, far, effect("a", 38, -10), correction(37, -11)},
         Verdict::cause_named,
         {"a"}})
        .says = Says::between_places;
    add({"unless it is more probable than the name",
         {bad, far, effect("a", 38, -10), correction(37, -9)},
         Verdict::ambiguous,
         {"a"},
         Reason::correction})
        .says = Says::between_places;
    add({"and it has to know how places differ",
         {bad, far, effect("a", 38, -10), correction(37, -9)},
         Verdict::cause_named,
         {"a"}})
        .says = Says::nothing;
    add({"that says the same of the layer is none",
         {bad, far, effect("a", 38, -10, "base"), correction(37, -11, {"base"})},
         Verdict::cause_named,
         {"a"}});
    add({"nor one of instruments beside one of instruments",
         {bad, far, effect("a", 38, -10, "readings"), correction(37, -11, {"readings"})},
         Verdict::cause_named,
         {"a"}});
    add({"but of another layer",
         {bad, far, effect("a", 38, -10, "base"), correction(37, -11, {"base", "subgrade"})},
         Verdict::ambiguous,
         {"a"},
         Reason::correction});
    add({"nor one that is far less probable",
         {bad, far, effect("a", 38, -10), correction(45, -14)},
         Verdict::cause_named,
         {"a"}});
    add({"less probable, but it explains as much for what it takes",
         {bad, far, effect("a", 38, -10), correction(34, -15)},
         Verdict::ambiguous,
         {"a"},
         Reason::correction});
    add({"far less probable, whatever it explains",
         {bad, far, effect("a", 38, -10), correction(34, -20)},
         Verdict::cause_named,
         {"a"}});
    add({"a correction finds more beside the name",
         {bad, far, effect("a", 38, -10, "base")},
         Verdict::ambiguous,
         {"a"},
         Reason::finds_more})
        .beyond = {{"effect: a", "subgrade", 0.002}};
    add({"more of the same", {bad, far, effect("a", 38, -10, "base")}, Verdict::cause_named, {"a"}}).beyond = {
        {"effect: a", "base", 0.002}};
    add({"a further wrong reading beside those that are named may be, and is no other name",
         {bad, far, wrong_readings({"7"}, 40, -10), wrong_readings({"7", "9"}, 36, -11)},
         Verdict::cause_named,
         {"outlier"}});
    add({"so may a second effect beside one, whose probability is then that of both",
         {bad, far, effect("a", 60, -14), two("a", "b", 45, -16)}, // p = 0.017 and 0.2; 88 and 12 %
         Verdict::cause_named,
         {"a"}});
    add({"other readings are another name",
         {bad, far, wrong_readings({"7"}, 40, -10), wrong_readings({"8", "9"}, 36, -11)},
         Verdict::ambiguous,
         {"outlier"},
         Reason::several_names});
    // What was seen before any model.
    add({"a fault alone", {rise, nothing(40, 0)}, Verdict::cause_named, {"sensor-position"}}).score = 0.4;
    add({"a fault beside an effect",
         {rise, bad, far, effect("a", 38, -10)},
         Verdict::cause_named,
         {"sensor-position", "a"}});
    // Without stated noise the size of chi2 says nothing.
    {
        Case& own = add({"no score stands out", {nothing(40, 0)}, Verdict::adequate});
        own.score = 0.3;
        own.noise_is_stated = false;
    }
    add({"an effect of evidence", {nothing(90, -20), effect("a", 40, -6)}, Verdict::cause_named, {"a"}})
        .noise_is_stated = false;
    return list;
}

} // namespace ledgers
