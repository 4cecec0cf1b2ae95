#define WF_LANES 8
#define WF_EVALUATE evaluate_avx512
#define WF_EIGEN Eigen_tune_avx512
#define WF_WAYFARE wayfare_tune_avx512
#include "tune/kernel.inl"
