#include "fe/lanes/inputs.h"

#include "material/power_law.h"

#include <algorithm>

namespace pave::fe::lanes {
namespace {
using Kind = Variation::Kind;
}

Inputs::Inputs(const Model<Element>& m, const Kernels& k)
    : model(&m),
      kernels(k),
      width(static_cast<std::size_t>(k.lanes)),
      layout(*m.topology),
      structure(layout.structure()),
      shapes(Layout::shapes(m)),
      mesh(layout.elements(shapes)) {}

void Inputs::move(const Model<Element>& to) {
    model = &to;
    shapes = Layout::shapes(to);
    mesh = layout.elements(shapes);
}

Points Inputs::points_of_path() const {
    const bool has_initial_rate = std::any_of(variations->begin(), variations->end(), [](const Variation& v) {
        return v.kind == Kind::unit_weight || v.kind == Kind::k0 || v.kind == Kind::residual_stress;
    });
    return {.elements = active.data(),
            .count = static_cast<int>(active.size()),
            .variations = static_cast<int>(count()),
            .initial = initial.data(),
            .initial_rate = has_initial_rate ? initial_rate.data() : nullptr,
            .unit = unit.data(),
            .unit_rate = unit_rate.data(),
            .unit_varies = unit_varies.get(),
            .moduli = laws.data(),
            .explicit_by = explicit_by.data(),
            .function = {.call = ask_law, .context = this}};
}

void Inputs::ask_law(const void* context, int l, int lane, double theta, double tau, ModulusOfLane* result,
                     double* by_variation) {
    const Inputs& w = *static_cast<const Inputs*>(context);
    const LayerMaterial& layer = w.layer(static_cast<std::size_t>(lane), static_cast<std::size_t>(l));
    const mechanics::Invariants at{theta, tau};
    const material::Modulus m = layer.law->modulus(layer.parameters, at);
    *result = {m.value, m.d_theta, m.d_tau, m.limited ? -1 : 0};
    for (std::size_t k = 0; k < w.count(); ++k) {
        const Variation& v = (*w.variations)[k];
        if (v.kind == Kind::law_parameter && v.layer == l) {
            by_variation[k] = layer.law->modulus_derivative(layer.parameters, at, m, v.index);
        }
    }
}

void Inputs::set_stiffness(Buffer& buffer, std::size_t which, std::size_t lane,
                           const mechanics::Stiffness<4>& c) const {
    const double numbers[unit_numbers] = {c(0, 0), c(0, 1), c(0, 2), c(2, 2), c(3, 3)};
    for (std::size_t i = 0; i < unit_numbers; ++i) {
        buffer[(which * unit_numbers + i) * width + lane] = numbers[i];
    }
}

void Inputs::prepare(std::span<const BatchRun> some, const std::vector<Variation>& by) {
    variations = &by;
    runs.assign(some.begin(), some.end());
    while (runs.size() < width) {
        runs.push_back(some[0]);
    }
    std::vector<std::vector<int>> elements(layers());
    active.clear();
    active_number.assign(static_cast<std::size_t>(model->elements()), 0);
    for (int e = 0; e < model->elements(); ++e) {
        const auto l = static_cast<std::size_t>(layout.layer[static_cast<std::size_t>(e)]);
        if (is_linear(l)) {
            elements[l].push_back(e);
        } else {
            active_number[static_cast<std::size_t>(e)] = active.size();
            active.push_back(e);
        }
    }
    of_layer = std::move(elements);
    whole = std::any_of(by.begin(), by.end(), [&](const Variation& v) {
        return v.kind == Kind::law_parameter && is_linear(static_cast<std::size_t>(v.layer));
    });
    prepare_layers();
    prepare_points();
    load.resize(rows(), kernels.lanes);
    for (std::size_t lane = 0; lane < width; ++lane) {
        for (std::size_t i = 0; i < rows(); ++i) {
            load[layout.inverse[i] * width + lane] = (*runs[lane].load)[static_cast<Eigen::Index>(i)];
        }
    }
}

void Inputs::prepare_layers() {
    const std::size_t n = count();
    unit.assign_zero(layers() * unit_numbers, kernels.lanes);
    compliance.assign_zero(layers() * unit_numbers, kernels.lanes);
    modulus.assign_zero(layers(), kernels.lanes);
    law_numbers.assign_zero(layers() * power_numbers, kernels.lanes);
    unit_rate.assign_zero(layers() * n * unit_numbers, kernels.lanes);
    modulus_rate.assign_zero(layers() * n, kernels.lanes);
    laws.assign(layers(), {});
    explicit_by.assign(layers() * n, Explicit::none);
    unit_varies = std::make_unique<bool[]>(layers() * n);
    for (std::size_t l = 0; l < layers(); ++l) {
        for (std::size_t lane = 0; lane < width; ++lane) {
            prepare_layer(l, lane);
        }
    }
}

void Inputs::prepare_layer(std::size_t l, std::size_t lane) {
    const std::size_t n = count();
    const LayerMaterial& own = layer(lane, l);
    const mechanics::Stiffness<4> c = own.unit_stiffness<4>();
    set_stiffness(unit, l, lane, c);
    set_stiffness(compliance, l, lane, c.inverse());
    std::optional<material::PowerLaw> power;
    if (is_linear(l)) {
        modulus[l * width + lane] = own.law->modulus(own.parameters, {}).value;
    } else if ((power = material::power_law(*own.law, own.parameters))) {
        const double numbers[power_numbers] = {power->k1_pa, power->k2, power->k3, power->delta, power->eta};
        for (std::size_t i = 0; i < power_numbers; ++i) {
            law_numbers[(l * power_numbers + i) * width + lane] = numbers[i];
        }
        laws[l] = {.is_power = true, .numbers = law_numbers.data() + l * power_numbers * width};
    }
    for (std::size_t k = 0; k < n; ++k) {
        const Variation& v = (*variations)[k];
        if (v.kind != Kind::law_parameter || v.layer != static_cast<int>(l)) {
            continue;
        }
        const mechanics::Stiffness<4> rate = own.unit_stiffness_rate<4>(v.index);
        set_stiffness(unit_rate, l * n + k, lane, rate);
        unit_varies[l * n + k] = unit_varies[l * n + k] || !rate.isZero(0.0);
        if (is_linear(l)) {
            modulus_rate[(l * n + k) * width + lane] =
                own.law->modulus_derivative(own.parameters, {}, {.value = modulus[l * width + lane]}, v.index);
            continue;
        }
        Explicit& by = explicit_by[l * n + k];
        const int index = static_cast<int>(v.index);
        by = !power                        ? Explicit::other
             : index == power->k1_index    ? Explicit::k1
             : index == power->k2_index    ? Explicit::k2
             : index == power->k3_index    ? Explicit::k3
             : index == power->delta_index ? Explicit::delta
             : index == power->eta_index   ? Explicit::eta
                                           : Explicit::none;
    }
}

void Inputs::prepare_points() {
    const std::size_t n = count();
    initial.resize(2 * points(), kernels.lanes);
    initial_rate.resize(2 * points() * n, kernels.lanes);
    modulus_at.resize(points(), kernels.lanes);
    modulus_rate_at.resize(points() * n, kernels.lanes);
    for (std::size_t q = 0; q < points(); ++q) {
        const auto e = static_cast<std::size_t>(active[q / Element::gauss]);
        const double z = model->depth[e * Element::gauss + q % Element::gauss];
        const int l = layout.layer[e];
        for (std::size_t lane = 0; lane < width; ++lane) {
            const auto stress = layer(lane, static_cast<std::size_t>(l)).initial_stress<4>(z);
            initial[2 * q * width + lane] = stress[0];
            initial[(2 * q + 1) * width + lane] = stress[2];
            for (std::size_t k = 0; k < n; ++k) {
                const auto rate = initial_stress_rate<4>(*runs[lane].layers, l, z, (*variations)[k]);
                initial_rate[2 * (q * n + k) * width + lane] = rate[0];
                initial_rate[(2 * (q * n + k) + 1) * width + lane] = rate[2];
            }
        }
    }
}

std::size_t Inputs::bytes() const {
    std::size_t sum = shapes.size() * sizeof(double);
    for (const Buffer* b : {&unit, &compliance, &modulus, &unit_rate, &modulus_rate, &law_numbers, &initial,
                            &initial_rate, &modulus_at, &modulus_rate_at, &load}) {
        sum += b->bytes();
    }
    return sum;
}

} // namespace pave::fe::lanes
