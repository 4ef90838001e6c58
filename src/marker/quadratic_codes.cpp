#include "marker/quadratic_codes.h"

#include <array>
#include <vector>

#include "marker/block_code.h"

namespace chequer {
namespace {

constexpr unsigned kBits = 16;
constexpr unsigned kReedMullerWords = 32;

/// The bits x1 … x4 of a cell's number, x1 the most significant.
std::array<unsigned, 4> Coordinates(unsigned cell) { return {cell >> 3 & 1, cell >> 2 & 1, cell >> 1 & 1, cell & 1}; }

/// The word of a0 + a1·x1 + … + a4·x4; a0 is the most significant of the id's five bits.
std::uint64_t ReedMullerWord(unsigned id) {
  std::uint64_t word = 0;
  for (unsigned cell = 0; cell < kBits; ++cell) {
    unsigned value = id >> 4;
    for (unsigned i = 0; const unsigned x : Coordinates(cell)) value ^= id >> (3 - i++) & x;
    word = word << 1 | (value & 1);
  }
  return word;
}

/// The word of the sum of the products x1x2, x1x3, x1x4, x2x3, x2x4, x3x4 whose bit, counted from the lowest, is set.
std::uint64_t QuadraticWord(unsigned form) {
  std::uint64_t word = 0;
  for (unsigned cell = 0; cell < kBits; ++cell) {
    const std::array<unsigned, 4> x = Coordinates(cell);
    unsigned value = 0;
    unsigned pair = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (std::size_t j = i + 1; j < x.size(); ++j) value ^= form >> pair++ & x[i] & x[j];
    }
    word = word << 1 | (value & 1);
  }
  return word;
}

/// Any two of them differ by a form of full rank (a Kerdock set), which puts the cosets six bits apart.
constexpr std::array<unsigned, 8> kForms{0, 12, 22, 27, 39, 41, 53, 58};

}  // namespace

std::unique_ptr<KernelCode> MakeReedMullerCode() {
  std::vector<std::uint64_t> words;
  for (unsigned id = 0; id < kReedMullerWords; ++id) words.push_back(ReedMullerWord(id));
  return std::make_unique<BlockCode>(std::move(words), kBits, 3);
}

std::unique_ptr<KernelCode> MakeNordstromRobinsonCode() {
  std::vector<std::uint64_t> words;
  for (const unsigned form : kForms) {
    for (unsigned id = 0; id < kReedMullerWords; ++id) words.push_back(ReedMullerWord(id) ^ QuadraticWord(form));
  }
  return std::make_unique<BlockCode>(std::move(words), kBits, 2);
}

}  // namespace chequer
