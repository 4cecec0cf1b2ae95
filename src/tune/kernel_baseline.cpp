#define WF_LANES 2
#define WF_EVALUATE evaluate_baseline
#define WF_EIGEN Eigen_tune_baseline
#define WF_WAYFARE wayfare_tune_baseline
#include "tune/kernel.inl"
