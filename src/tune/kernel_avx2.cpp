#define WF_LANES 4
#define WF_EVALUATE evaluate_avx2
#define WF_EIGEN Eigen_tune_avx2
#define WF_WAYFARE wayfare_tune_avx2
#include "tune/kernel.inl"
