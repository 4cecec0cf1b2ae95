#pragma once

// The functions of RTKLIB's library used as an oracle. Debian ships the library without its header,
// so they are declared here as of version 2.4.3 b34; the test `Rtklib.MatchesTheDeclarations`
// guards the declarations.

#include <cstdint>
#include <ctime>

extern "C" {

struct gtime_t {
  time_t time;
  double sec;
};

struct eph_t {
  int sat, iode, iodc, sva, svh, week, code, flag;
  gtime_t toe, toc, ttr;
  double A, e, i0, OMG0, omg, M0, deln, OMGd, idot, crc, crs, cuc, cus, cic, cis;
  double toes, fit, f0, f1, f2;
  double reserve[64];  // group delays and more, not used by the functions below
};

struct geph_t {
  int sat, iode, frq, svh, sva, age;
  gtime_t toe, tof;
  double pos[3], vel[3], acc[3];
  double taun, gamn, dtaun;
  double reserve[16];
};

// Of the Debian package, which is built for eight signals and 221 satellites.
struct obsd_t {
  gtime_t time;
  std::uint8_t sat, rcv;
  std::uint16_t SNR[8];  // 0.001 dB-Hz
  std::uint8_t LLI[8], code[8];
  double L[8], P[8];
  float D[8];
};

/// The beginning of raw_t, of about 1 MB.
struct raw_t {
  gtime_t time;
  gtime_t tobs[221][8];
  int n, nmax;
  obsd_t* data;
  std::uint8_t before_nav[0x6ee8 - 0x6ea0];
  std::uint8_t* eph;  ///< an eph_t every 304 bytes, for twice the satellites
  std::uint8_t rest[1 << 21];
};

/// A solution, Earth-fixed: position and velocity; variances xx, yy, zz, xy, yz, zx.
struct sol_t {
  gtime_t time;
  double rr[6];
  float qr[6], qv[6];
  double dtr[6];
  std::uint8_t type, stat, ns;
  float age, ratio, thres;
};

struct solbuf_t {
  int n, nmax, cyclic, start, end;
  gtime_t time;
  sol_t* data;
  double rb[3];
  std::uint8_t rest[1 << 16];
};

int readsol(char* files[], int nfile, solbuf_t* sol);
void freesolbuf(solbuf_t* sol);
int init_raw(raw_t* raw, int format);
void free_raw(raw_t* raw);
int input_ubx(raw_t* raw, std::uint8_t data);
int satno(int sys, int prn);
gtime_t gpst2time(int week, double sec);
void eph2pos(gtime_t time, const eph_t* eph, double* rs, double* dts, double* var);
void geph2pos(gtime_t time, const geph_t* geph, double* rs, double* dts, double* var);
double ionmodel(gtime_t t, const double* ion, const double* pos, const double* azel);
double tropmodel(gtime_t time, const double* pos, const double* azel, double humi);
double tropmapf(gtime_t time, const double* pos, const double* azel, double* mapfw);
double geodist(const double* rs, const double* rr, double* e);
double satazel(const double* pos, const double* e, double* azel);
void ecef2pos(const double* r, double* pos);
}
