#include "fe/sparse_solver.h"

#include <algorithm>
#include <atomic>
#include <cholmod.h>
#include <cstring>
#include <fmt/format.h>
#include <new>
#include <umfpack.h>

namespace pave::fe {
namespace {
std::atomic<int> analyses{0};
}

int CholeskyAnalysis::made() {
    return analyses;
}

CholeskyAnalysis::CholeskyAnalysis(const Pattern& lower, const std::vector<bool>& constant,
                                   const std::vector<bool>& first) {
    ++analyses;
    cholmod_common common{};
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    cholmod_sparse matrix{};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(lower.size);
    matrix.nzmax = lower.row.size();
    matrix.p = const_cast<int*>(lower.column_start.data()); // CHOLMOD reads them only
    matrix.i = const_cast<int*>(lower.row.data());
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_PATTERN;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = 1;
    matrix.packed = 1;
    std::vector<int> given;
    if (!first.empty()) {
        std::vector<int> group(first.size());
        std::transform(first.begin(), first.end(), group.begin(), [](bool is) { return is ? 0 : 1; });
        given.resize(first.size());
        cholmod_camd(&matrix, nullptr, 0, group.data(), given.data(), &common);
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_GIVEN;
    }
    cholmod_factor* factor = cholmod_analyze_p(&matrix, given.empty() ? nullptr : given.data(), nullptr, 0, &common);
    if (factor == nullptr) {
        cholmod_finish(&common);
        throw std::bad_alloc();
    }
    const auto* order = static_cast<const int*>(factor->Perm);
    const auto* super = static_cast<const int*>(factor->super);
    const auto* start = static_cast<const int*>(factor->pi);
    const auto* rows = static_cast<const int*>(factor->s);
    std::vector<std::vector<int>> rows_of;
    for (std::size_t k = 0; k < factor->nsuper; ++k) {
        rows_of.emplace_back(rows + start[k], rows + start[k + 1]);
    }
    structure_ =
        FactorStructure(lower, {order, order + factor->n}, {super, super + factor->nsuper + 1}, rows_of, constant);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
}

struct SparseLu::Implementation {
    const Pattern* pattern = nullptr;
    std::span<const double> values;
    double control[UMFPACK_CONTROL] = {};
    double info[UMFPACK_INFO] = {};
    void* symbolic = nullptr;
    void* numeric = nullptr;
    std::vector<int> work_int;
    std::vector<double> work;
    std::vector<double> right;
};

SparseLu::SparseLu(const Pattern& full) : implementation_(std::make_unique<Implementation>()) {
    auto& m = *implementation_;
    m.pattern = &full;
    umfpack_di_defaults(m.control);
    m.control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
    m.control[UMFPACK_IRSTEP] = 1;
    const auto n = static_cast<std::size_t>(full.size);
    m.work_int.resize(n);
    m.work.resize(5 * n);
    m.right.resize(n);
}

SparseLu::~SparseLu() {
    umfpack_di_free_numeric(&implementation_->numeric);
    umfpack_di_free_symbolic(&implementation_->symbolic);
}

bool SparseLu::factorize(std::span<const double> values) {
    auto& m = *implementation_;
    m.values = values;
    const int* starts = m.pattern->column_start.data();
    const int* rows = m.pattern->row.data();
    if (m.symbolic == nullptr && umfpack_di_symbolic(m.pattern->size, m.pattern->size, starts, rows, nullptr,
                                                     &m.symbolic, m.control, m.info) != UMFPACK_OK) {
        throw std::bad_alloc();
    }
    umfpack_di_free_numeric(&m.numeric);
    const int status = umfpack_di_numeric(starts, rows, values.data(), m.symbolic, &m.numeric, m.control, m.info);
    if (status == UMFPACK_ERROR_out_of_memory) {
        throw std::bad_alloc();
    }
    return status == UMFPACK_OK;
}

void SparseLu::solve(double* x, int columns) {
    auto& m = *implementation_;
    for (int k = 0; k < columns; ++k) {
        double* column = x + static_cast<std::ptrdiff_t>(k) * m.pattern->size;
        std::memcpy(m.right.data(), column, m.right.size() * sizeof(double));
        umfpack_di_wsolve(UMFPACK_A, m.pattern->column_start.data(), m.pattern->row.data(), m.values.data(), column,
                          m.right.data(), m.numeric, m.control, m.info, m.work_int.data(), m.work.data());
    }
}

std::string sparse_solver_version() {
    return fmt::format("CHOLMOD {}.{}.{}", CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION);
}

} // namespace pave::fe
