#include "lin.h"

#include <algorithm>
#include <cassert>
#include <complex>
#include <limits>

#define EIGEN_NO_MALLOC
/* GCC 12 cannot see that Eigen's fixed storage holds at least one element. */
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace {

/* The storage is inside the matrix, not on the heap. */
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, LIN_MAX, LIN_MAX>;
/* Limited to LIN_COMPLEX_MAX, because Eigen clears complex storage, and clearing LIN_MAX rows and
 * columns would take longer than finding the eigenvalues. */
using Complex = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, LIN_COMPLEX_MAX, LIN_COMPLEX_MAX>;
using Svd = Eigen::JacobiSVD<Matrix, Eigen::NoQRPreconditioner>; /* this variant takes square
                                                                  * matrices only */
using Input = Eigen::Map<const Matrix>;
using Output = Eigen::Map<Matrix>;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

bool fits(int rows, int columns) { return rows >= 1 && rows <= LIN_MAX && columns >= 1 && columns <= LIN_MAX; }

lin_report refuse(Output &x) {
    x.setConstant(nan_value);
    return {0, infinite};
}

lin_report solve_right(const Matrix &a, const Matrix &b, Output &x) {
    const Svd decomposition(Matrix(a.transpose()), Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (decomposition.info() != Eigen::Success) return refuse(x);
    const Matrix transposed = decomposition.solve(Matrix(b.transpose()));
    const auto &values = decomposition.singularValues();
    const int n = static_cast<int>(a.rows()), rank = static_cast<int>(decomposition.rank());
    x = transposed.transpose();
    return {rank, rank == n ? values(0) / values(n - 1) : infinite};
}

}

lin_report lin_solve_right(int n, int m, const double *a, const double *b, double *x) noexcept {
    assert(fits(n, m));
    const Matrix left = Input(a, n, n), right = Input(b, m, n);
    Output result(x, m, n);
    if (!left.allFinite() || !right.allFinite()) return refuse(result);
    return solve_right(left, right, result);
}

lin_report lin_inverse(int n, const double *a, double *inverse) noexcept {
    assert(fits(n, n));
    const Matrix left = Input(a, n, n);
    Output result(inverse, n, n);
    if (!left.allFinite()) return refuse(result);
    return solve_right(left, Matrix::Identity(n, n), result);
}

int lin_eigenvalues(int n, const double *a, double *eigenvalues) noexcept {
    assert(fits(n, n));
    const Matrix lower = Matrix(Input(a, n, n)).triangularView<Eigen::Lower>();
    if (!lower.allFinite()) return -1;
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(lower, Eigen::EigenvaluesOnly);
    if (solver.info() != Eigen::Success) return -1;
    Output(eigenvalues, n, 1) = solver.eigenvalues();
    return 0;
}

int lin_eigenvectors(int n, const double *a, const double *b, double *eigenvalues, double *vectors) noexcept {
    assert(fits(n, n));
    const Matrix left = Input(a, n, n), right = Input(b, n, n);
    if (!left.allFinite() || !right.allFinite()) return -1;
    if (Eigen::LLT<Matrix>(right).info() != Eigen::Success) return -1;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> solver(left, right);
    if (solver.info() != Eigen::Success) return -1;
    Output(eigenvalues, n, 1) = solver.eigenvalues();
    Output(vectors, n, n) = solver.eigenvectors().transpose();
    return 0;
}

int lin_poles(int n, const double *a, double *real, double *imaginary) noexcept {
    assert(fits(n, n));
    const Matrix square = Input(a, n, n);
    if (!square.allFinite()) return -1;
    const Eigen::EigenSolver<Matrix> solver(square, false);
    if (solver.info() != Eigen::Success) return -1;
    Output(real, n, 1) = solver.eigenvalues().real();
    Output(imaginary, n, 1) = solver.eigenvalues().imag();
    return 0;
}

int lin_complex_eigenvalues(int n, const double *a, double *eigenvalues) noexcept {
    assert(n >= 1 && n <= LIN_COMPLEX_MAX);
    const Complex square = Eigen::Map<const Complex>(reinterpret_cast<const std::complex<double> *>(a), n, n);
    if (!square.allFinite()) return -1;
    const Eigen::ComplexEigenSolver<Complex> solver(square, false);
    if (solver.info() != Eigen::Success) return -1;
    for (int i = 0; i < n; i++)
        eigenvalues[2 * i] = solver.eigenvalues()(i).real(), eigenvalues[2 * i + 1] = solver.eigenvalues()(i).imag();
    return 0;
}

int lin_singular_values(int m, int n, const double *a, double *values) noexcept {
    assert(fits(m, n));
    /* Padding to a square adds only zero singular values, which sort to the end. */
    Matrix square = Matrix::Zero(std::max(m, n), std::max(m, n));
    square.topLeftCorner(m, n) = Input(a, m, n);
    if (!square.allFinite()) return -1;
    const Svd decomposition(square);
    if (decomposition.info() != Eigen::Success) return -1;
    Output(values, std::min(m, n), 1) = decomposition.singularValues().head(std::min(m, n));
    return 0;
}

lin_report lin_solve_spd(int n, int m, const double *a, const double *b, double *x) noexcept {
    assert(fits(n, m));
    const Matrix left = Input(a, n, n), right = Input(b, n, m);
    Output result(x, n, m);
    double eigenvalues[LIN_MAX];
    if (!right.allFinite() || lin_eigenvalues(n, a, eigenvalues) != 0) return refuse(result);
    const double smallest = eigenvalues[0], largest = eigenvalues[n - 1];
    const double threshold = n * std::numeric_limits<double>::epsilon() * std::max(largest, -smallest);
    int rank = 0;
    for (int i = 0; i < n; i++) rank += eigenvalues[i] > threshold;
    if (rank < n) {
        result.setConstant(nan_value);
        return {rank, infinite};
    }
    result = Eigen::LDLT<Matrix>(left).solve(right);
    return {rank, largest / smallest};
}
