// What a forward run and its derivatives cost beside one sparse Cholesky factorisation of the same matrix by CHOLMOD.
// A plane case and a solid one; five derivatives: of four numbers of the base and the modulus of the subgrade. And a
// bowl of four linear layers by the layered engine, with the derivatives by its four moduli. The same sections with a
// hyperelastic base, which has no load path.
// usage: benchmarks [OPTIONS OF GOOGLE BENCHMARK], from the top of the repository
#include "material/catalog.h"
#include "pavement/forward.h"
#include "pavement/load_model.h"
#include "run/blas.h"
#include "study/problems.h"

#include <benchmark/benchmark.h>
#include <cholmod.h>
#include <dlfcn.h>

namespace {

using namespace pave;

// CHOLMOD asks OpenMP for four threads in every supernode; here everything is measured on one.
void keep_openmp_serial() {
    const auto set_levels = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
    if (set_levels != nullptr) {
        set_levels(0);
    }
}

// The stiffness matrix of the whole section at its initial stress, lower triangle.
template <class Kind>
std::vector<double> matrix_of(const pavement::Parts<Kind>& parts) {
    using Element = typename Kind::Element;
    const auto& topology = *parts.model.topology;
    std::vector<double> values(topology.lower.row.size(), 0.0);
    for (int e = 0; e < parts.model.elements(); ++e) {
        const auto& layer = parts.layers[static_cast<std::size_t>(topology.layer[e])];
        const mechanics::Stiffness<Element::voigt> unit =
            layer.law->unit_stiffness(layer.parameters, {}).template topLeftCorner<Element::voigt, Element::voigt>();
        Eigen::Matrix<double, Element::dofs, Element::dofs> k =
            Eigen::Matrix<double, Element::dofs, Element::dofs>::Zero();
        for (int g = 0; g < Element::gauss; ++g) {
            const int q = e * Element::gauss + g;
            const auto at = mechanics::invariants<Element::voigt>(
                layer.template initial_stress<Element::voigt>(parts.model.depth[q]));
            const auto b = Element::strain_operator(parts.model.points[q]);
            const typename Element::Operator db =
                layer.law->modulus(layer.parameters, at).value * parts.model.points[q].weight * (unit * b);
            k += b.transpose() * db;
        }
        int entry = 0;
        for (int i = 0; i < Element::dofs; ++i) {
            for (int j = 0; j <= i; ++j, ++entry) {
                if (const int place = topology.scatter[e][entry]; place >= 0) {
                    values[place] += k(i, j);
                }
            }
        }
    }
    return values;
}

template <class Kind>
void factorisation(benchmark::State& state, const std::string& file) {
    const auto study = explore::study::load_study(file);
    const auto parts = pavement::parts_of<Kind>(study.model, 0);
    auto values = matrix_of(parts);
    auto pattern = parts.model.topology->lower;
    cholmod_common common{};
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    cholmod_sparse matrix{};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(pattern.size);
    matrix.nzmax = pattern.row.size();
    matrix.p = pattern.column_start.data();
    matrix.i = pattern.row.data();
    matrix.x = values.data();
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_REAL;
    matrix.sorted = matrix.packed = 1;
    cholmod_factor* factor = cholmod_analyze(&matrix, &common);
    for (auto _ : state) {
        cholmod_factorize(&matrix, factor, &common);
    }
    if (factor->minor != factor->n) {
        state.SkipWithError("the matrix is not positive definite");
    }
    state.counters["unknowns"] = pattern.size;
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
}

// The section of a study, its layer of `uzan` hyperelastic: no load path.
pavement::Case hyperelastic(const std::string& file) {
    auto c = explore::study::load_study(file).model;
    for (pavement::Layer& layer : c.layers) {
        if (layer.law == material::find_law("uzan")) {
            const auto value = [&](std::string_view key) { return layer.parameters[*layer.law->index_of(key)]; };
            const double n = value("n");
            const double delta = value("tension_smoothing_kPa");
            layer.parameters = {value("modulus_axis"), value("k1"),         0.5,  n, value("poisson_12"),
                                value("poisson_31"),   material::not_given, delta};
            layer.law = material::find_law("hyperelastic");
        }
    }
    return c;
}

void forward(benchmark::State& state, const pavement::Case& c, const std::vector<std::string>& by) {
    const pavement::ForwardModel model(c);
    std::vector<pavement::Parameter> parameters;
    for (const std::string& path : by) {
        parameters.push_back(pavement::find_parameter(c, path, {}));
    }
    const auto workspace = model.make_workspace();
    fe::Statistics statistics;
    for (auto _ : state) {
        const auto outcome = model.run(c, parameters, *workspace);
        if (!outcome) {
            state.SkipWithError(outcome.failure().reason.c_str());
            return;
        }
        statistics = outcome->statistics;
    }
    state.counters["load_steps"] = statistics.load_steps;
    state.counters["newton_steps"] = statistics.newton_steps;
    state.counters["factorizations"] = statistics.factorizations;
    state.counters["iterations"] = statistics.iterations;
}

} // namespace

int main(int argc, char** argv) {
    explore::run::prepare_blas();
    keep_openmp_serial();
    const std::string plane = "grids/captif-p1-fwd.toml";
    const std::string solid = "grids/dual-nonlinear.toml";
    const std::string layered = "grids/layered-bowl.toml";
    const std::vector<std::string> moduli{"asphalt.modulus_MPa", "base.modulus_MPa", "subbase.modulus_MPa",
                                          "subgrade.modulus_MPa"};
    const std::vector<std::string> five{"base.k1", "base.k2", "base.k3", "base.n", "subgrade.modulus_MPa"};
    const std::vector<std::string> of_energy{"base.k1", "base.k", "base.n", "base.poisson_31", "subgrade.modulus_MPa"};
    const auto model_of = [](const std::string& file) { return explore::study::load_study(file).model; };
    const auto add = [](const std::string& name, const auto& action) {
        benchmark::RegisterBenchmark(name.c_str(), action)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
    };
    add("plane/factorisation", [&](auto& state) { factorisation<pavement::Axisymmetric>(state, plane); });
    add("plane/forward", [&](auto& state) { forward(state, model_of(plane), {}); });
    add("plane/jacobian", [&](auto& state) { forward(state, model_of(plane), five); });
    add("plane/geometry", [&](auto& state) {
        forward(state, model_of(plane), {"base.thickness_mm", "fwd.radius_mm"});
    });
    add("plane/hyperelastic", [&](auto& state) { forward(state, hyperelastic(plane), {}); });
    add("plane/hyperelastic-jacobian", [&](auto& state) { forward(state, hyperelastic(plane), of_energy); });
    add("layered/forward", [&](auto& state) { forward(state, model_of(layered), {}); });
    add("layered/jacobian", [&](auto& state) { forward(state, model_of(layered), moduli); });
    add("solid/factorisation", [&](auto& state) { factorisation<pavement::Solid>(state, solid); });
    add("solid/forward", [&](auto& state) { forward(state, model_of(solid), {}); });
    add("solid/jacobian", [&](auto& state) { forward(state, model_of(solid), five); });
    add("solid/hyperelastic", [&](auto& state) { forward(state, hyperelastic(solid), {}); });
    add("solid/hyperelastic-jacobian", [&](auto& state) { forward(state, hyperelastic(solid), of_energy); });
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
        return 2;
    }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
