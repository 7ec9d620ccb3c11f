#include "fe/sparse_solver.h"

#include <atomic>
#include <cholmod.h>
#include <cstring>
#include <dlfcn.h>
#include <new>
#include <umfpack.h>

namespace pave::fe {
namespace {

// CHOLMOD is built with OpenMP and asks for four threads in every supernode, whatever OMP_NUM_THREADS says. Here
// the parallelism is over runs: no active parallel regions on this thread, where OpenMP is there at all.
void keep_openmp_serial() {
    static auto* const set_levels = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
    if (set_levels != nullptr) {
        set_levels(0);
    }
}

} // namespace

struct CholeskyAnalysis::Implementation {
    cholmod_common common{};
    cholmod_factor* symbolic = nullptr;
};

struct SparseCholesky::Implementation {
    cholmod_common common{};
    cholmod_sparse matrix{};
    cholmod_factor* factor = nullptr;
    cholmod_dense* solution = nullptr;
    cholmod_dense* work_y = nullptr;
    cholmod_dense* work_e = nullptr;
};

namespace {

void start(cholmod_common& common) {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.quick_return_if_not_posdef = 1;
}

cholmod_sparse matrix_of(const Pattern& lower) {
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
    return matrix;
}

} // namespace

namespace {
std::atomic<int> analyses{0};
}

int CholeskyAnalysis::made() {
    return analyses;
}

CholeskyAnalysis::CholeskyAnalysis(const Pattern& lower) : implementation_(std::make_unique<Implementation>()) {
    ++analyses;
    auto& m = *implementation_;
    start(m.common);
    cholmod_sparse matrix = matrix_of(lower);
    m.symbolic = cholmod_analyze(&matrix, &m.common);
    if (m.symbolic == nullptr) {
        throw std::bad_alloc();
    }
}

CholeskyAnalysis::~CholeskyAnalysis() {
    cholmod_free_factor(&implementation_->symbolic, &implementation_->common);
    cholmod_finish(&implementation_->common);
}

SparseCholesky::SparseCholesky(const Pattern& lower, const CholeskyAnalysis& analysis)
    : implementation_(std::make_unique<Implementation>()) {
    auto& m = *implementation_;
    start(m.common);
    m.matrix = matrix_of(lower);
    m.matrix.xtype = CHOLMOD_REAL;
    m.factor = cholmod_copy_factor(analysis.implementation_->symbolic, &m.common);
    if (m.factor == nullptr) {
        throw std::bad_alloc();
    }
}

SparseCholesky::~SparseCholesky() {
    auto& m = *implementation_;
    cholmod_free_dense(&m.solution, &m.common);
    cholmod_free_dense(&m.work_y, &m.common);
    cholmod_free_dense(&m.work_e, &m.common);
    cholmod_free_factor(&m.factor, &m.common);
    cholmod_finish(&m.common);
}

bool SparseCholesky::factorize(std::span<const double> values) {
    auto& m = *implementation_;
    keep_openmp_serial();
    m.matrix.x = const_cast<double*>(values.data());
    cholmod_factorize(&m.matrix, m.factor, &m.common);
    if (m.common.status == CHOLMOD_OUT_OF_MEMORY) {
        throw std::bad_alloc();
    }
    return m.common.status == CHOLMOD_OK && m.factor->minor == m.factor->n;
}

void SparseCholesky::solve(double* x, int columns) {
    keep_openmp_serial();
    auto& m = *implementation_;
    cholmod_dense right{};
    right.nrow = right.d = m.factor->n;
    right.ncol = static_cast<std::size_t>(columns);
    right.nzmax = right.nrow * right.ncol;
    right.x = x;
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    if (cholmod_solve2(CHOLMOD_A, m.factor, &right, nullptr, &m.solution, nullptr, &m.work_y, &m.work_e, &m.common) ==
        0) {
        throw std::bad_alloc();
    }
    std::memcpy(x, m.solution->x, right.nzmax * sizeof(double));
}

void SparseCholesky::round_to(SingleFactor& single) const {
    const cholmod_factor& factor = *implementation_->factor;
    const auto* permutation = static_cast<const int*>(factor.Perm);
    const auto* super = static_cast<const int*>(factor.super); // first column of each supernode
    const auto* row_start = static_cast<const int*>(factor.pi);
    const auto* value_start = static_cast<const int*>(factor.px);
    const auto* rows = static_cast<const int*>(factor.s);
    const auto* values = static_cast<const double*>(factor.x);
    single.permutation.assign(permutation, permutation + factor.n);
    single.supernodes.resize(factor.nsuper);
    single.rows.clear();
    single.values.clear();
    for (std::size_t k = 0; k < factor.nsuper; ++k) {
        auto& s = single.supernodes[k];
        const int all_rows = row_start[k + 1] - row_start[k];
        s.first_column = super[k];
        s.columns = super[k + 1] - super[k];
        s.rows_below = all_rows - s.columns;
        s.row_start = single.rows.size();
        s.start = single.values.size();
        single.rows.insert(single.rows.end(), rows + row_start[k] + s.columns, rows + row_start[k + 1]);
        const Eigen::Map<const Eigen::MatrixXd> block(values + value_start[k], all_rows, s.columns);
        const Eigen::MatrixXf inverse = block.topRows(s.columns)
                                            .triangularView<Eigen::Lower>()
                                            .solve(Eigen::MatrixXd::Identity(s.columns, s.columns))
                                            .cast<float>();
        const Eigen::MatrixXf below = block.bottomRows(s.rows_below).cast<float>();
        single.values.insert(single.values.end(), inverse.data(), inverse.data() + inverse.size());
        single.values.insert(single.values.end(), below.data(), below.data() + below.size());
    }
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

} // namespace pave::fe
