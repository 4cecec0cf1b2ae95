// Part of kernels.cpp: a fixed number of lanes in every variant, so that sums round alike. They are
// stored in vectors of a register: on vectors wider than that GCC compares, chooses and converts
// number by number.

/// Of numbers that are read in wider ones.
constexpr bool kLittleEndian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;

#if defined(__AVX512F__)
constexpr int kRegister = 64;
#elif defined(__AVX2__)
constexpr int kRegister = 32;
#else
constexpr int kRegister = 16;
#endif

/// Lanes of a number type, with arithmetic lane by lane; zeros at first, a number converts to equal
/// lanes.
template <class Number, int kLanes>
struct Wide {
  static constexpr int kAll = kLanes * static_cast<int>(sizeof(Number));
  static constexpr int kBytes = kAll < kRegister ? kAll : kRegister;
  static constexpr int kPieces = kAll / kBytes, kPieceLanes = kLanes / kPieces;
  typedef Number Piece __attribute__((vector_size(kBytes)));

  Piece piece[kPieces] = {};

  Wide() = default;
  Wide(Number n) {
    for (Piece& p : piece) p = Piece{} + n;
  }

  static Wide loaded(const Number* from) {
    Wide v;
    for (int k = 0; k < kPieces; ++k) __builtin_memcpy(&v.piece[k], from + k * kPieceLanes, kBytes);
    return v;
  }
  /// Of numbers of a narrower type.
  template <class Narrow>
  static Wide widened(const Narrow* from) {
    typedef Narrow Narrows __attribute__((vector_size(kPieceLanes * sizeof(Narrow))));
    Wide v;
    for (int k = 0; k < kPieces; ++k) {
      Narrows n;
      __builtin_memcpy(&n, from + k * kPieceLanes, sizeof n);
      v.piece[k] = __builtin_convertvector(n, Piece);
    }
    return v;
  }
  /// f(lane) in each lane, which compilers set in a register: written to an array and loaded as a
  /// whole they wait for the stores.
  template <class F>
  static Wide of(F f) {
    Wide v;
    for (int k = 0; k < kPieces; ++k)
      v.piece[k] = [&]<std::size_t... J>(std::index_sequence<J...>) {
        return Piece{f(k * kPieceLanes + static_cast<int>(J))...};
      }
    (std::make_index_sequence<kPieceLanes>{});
    return v;
  }
  void store(Number* to) const {
    for (int k = 0; k < kPieces; ++k) __builtin_memcpy(to + k * kPieceLanes, &piece[k], kBytes);
  }
  Number operator[](int lane) const { return piece[lane / kPieceLanes][lane % kPieceLanes]; }

  friend Wide operator+(const Wide& a, const Wide& b) {
    return each([](auto p, auto q) { return p + q; }, a, b);
  }
  friend Wide operator-(const Wide& a, const Wide& b) {
    return each([](auto p, auto q) { return p - q; }, a, b);
  }
  friend Wide operator*(const Wide& a, const Wide& b) {
    return each([](auto p, auto q) { return p * q; }, a, b);
  }
  friend Wide operator/(const Wide& a, const Wide& b) {
    return each([](auto p, auto q) { return p / q; }, a, b);
  }
  friend Wide operator&(const Wide& a, const Wide& b) {
    return each([](auto p, auto q) { return p & q; }, a, b);
  }
  friend Wide operator-(const Wide& a) {
    return each([](auto p) { return -p; }, a);
  }
  Wide operator<<(int bits) const {
    return each([=](auto p) { return p << bits; }, *this);
  }
  Wide operator>>(int bits) const {
    return each([=](auto p) { return p >> bits; }, *this);
  }
  Wide& operator+=(const Wide& b) {
    for (int k = 0; k < kPieces; ++k) piece[k] += b.piece[k];
    return *this;
  }

  template <class F, class... In>
  static Wide each(F f, const In&... in) {
    Wide v;
    for (int k = 0; k < kPieces; ++k) v.piece[k] = f(in.piece[k]...);
    return v;
  }
};

using Reals = Wide<float, 16>;
using Ints = Wide<int32_t, 16>;
using Shorts = Wide<uint16_t, 16>;
using Sums = Wide<uint32_t, 16>;

/// 0, 1, 2, …
template <int L = 16>
inline Wide<int32_t, L> lane_numbers() {
  static_assert(L <= 16);
  constexpr int32_t kNumbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return Wide<int32_t, L>::loaded(kNumbers);
}
/// Whether one is not zero.
inline bool any_of(const Ints& v) {
  Ints::Piece all = v.piece[0];
  for (int k = 1; k < Ints::kPieces; ++k) all |= v.piece[k];
  uint64_t bits[kRegister / 8], any = 0;
  __builtin_memcpy(bits, &all, sizeof all);
  for (const uint64_t b : bits) any |= b;
  return any != 0;
}

/// sums[k] += v[k].
template <int L>
inline void add_to(uint32_t* sums, const Wide<uint16_t, L>& v) {
  uint16_t numbers[L];
  v.store(numbers);
  (Wide<uint32_t, L>::loaded(sums) + Wide<uint32_t, L>::widened(numbers)).store(sums);
}

/// a < b ? a : b, and its mirror image.
template <class N, int L>
inline Wide<N, L> lesser(const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<N, L>::each([](auto p, auto q) { return p < q ? p : q; }, a, b);
}
template <class N, int L>
inline Wide<N, L> greater(const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<N, L>::each([](auto p, auto q) { return p > q ? p : q; }, a, b);
}
/// −1 where it holds, else 0.
template <class N, int L>
inline Wide<int32_t, L> less(const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<int32_t, L>::each([](auto p, auto q) { return p < q; }, a, b);
}
template <class N, int L>
inline Wide<int32_t, L> at_most(const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<int32_t, L>::each([](auto p, auto q) { return p <= q; }, a, b);
}
template <class N, int L>
inline Wide<int32_t, L> equal(const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<int32_t, L>::each([](auto p, auto q) { return p == q; }, a, b);
}
template <class N, int L>
inline Wide<N, L> chosen(const Wide<int32_t, L>& where, const Wide<N, L>& a, const Wide<N, L>& b) {
  return Wide<N, L>::each([](auto w, auto p, auto q) { return w ? p : q; }, where, a, b);
}
/// Rounded towards zero.
inline Ints to_ints(const Reals& v) {
  return Ints::each([](auto p) { return __builtin_convertvector(p, Ints::Piece); }, v);
}
inline Reals to_reals(const Ints& v) {
  return Reals::each([](auto p) { return __builtin_convertvector(p, Reals::Piece); }, v);
}
inline Ints bits_of(const Reals& v) {
  return Ints::each([](auto p) { return reinterpret_cast<Ints::Piece>(p); }, v);
}
inline Reals of_bits(const Ints& v) {
  return Reals::each([](auto p) { return reinterpret_cast<Reals::Piece>(p); }, v);
}

typedef uint16_t EightSums __attribute__((vector_size(16)));
/// The first, third, … of sixteen bytes.
inline EightSums even_bytes(const uint8_t* p) {
  EightSums two;
  __builtin_memcpy(&two, p, sizeof two);
  return kLittleEndian ? two & 0xff : two >> 8;
}
