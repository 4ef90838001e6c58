#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// Cells of a board. rows and cols at least 3, at most 64 kernel cells.
struct MarkerSize {
  int rows = 6;
  int cols = 6;
  bool operator==(const MarkerSize&) const = default;
};

/// Whether the specification allows that size.
bool IsValid(MarkerSize size);
/// Kernel cells, (rows − 2)(cols − 2).
constexpr int KernelBits(MarkerSize size) { return (size.rows - 2) * (size.cols - 2); }
/// Border cells, 2(rows + cols) − 4.
constexpr int BorderLength(MarkerSize size) { return 2 * (size.rows + size.cols) - 4; }
/// Inner corners, (rows − 1)(cols − 1).
constexpr int CornerCount(MarkerSize size) { return (size.rows - 1) * (size.cols - 1); }
/// The most corners a valid size can have (3 × 66).
inline constexpr int kMaxCorners = 130;
/// The most cells a valid size can have (3 × 66).
inline constexpr int kMaxCells = 198;
/// "6x6" → {6, 6}; nothing if it is not a valid size.
std::optional<MarkerSize> ParseMarkerSize(std::string_view text);
std::string ToString(MarkerSize size);

/// Dark cells are those where row + column is even.
constexpr bool IsDark(int row, int col) { return (row + col) % 2 == 0; }
constexpr bool IsBorder(MarkerSize size, int row, int col) {
  return row == 0 || col == 0 || row == size.rows - 1 || col == size.cols - 1;
}

/// A cell's place, rows downwards, columns to the right, from 0.
struct Cell {
  int row = 0;
  int col = 0;
};

/// Border cells clockwise from (0, 0), BorderLength of them. @pre IsValid(size).
std::vector<Cell> BorderCells(MarkerSize size);

/// Saturation (1 = saturated) of the border cells in the order of BorderCells. @pre IsValid(size).
std::vector<std::uint8_t> BorderSaturation(MarkerSize size);

/// Saturation (1 = saturated) of all cells, row by row, of a board with that kernel.
/// Kernel bits row by row over the inner cells, the first the most significant. @pre IsValid(size).
std::vector<std::uint8_t> CellSaturation(MarkerSize size, std::uint64_t kernel);

/// 'K', 'W', 'B' or 'Y' for each cell, row by row. @pre IsValid(size).
std::string CellColours(MarkerSize size, std::uint64_t kernel);

/// The rules that map ids to kernels, and so which errors a code finds or mends.
enum class Variant : std::uint8_t {
  kUnconstrained,
  kSaturationConstrained,
  kColorConstrained,
  kSecded,
  kGolay,
  kNordstromRobinson,
  kReedMuller,
  kTable,  ///< a table of one's own
};
/// "unconstrained", "saturation_constrained", "color_constrained", "secded", "golay", "nordstrom_robinson",
/// "reed_muller", "table"; "unknown" for any other number, as a message of a newer version may carry.
std::string_view VariantName(Variant variant);
std::optional<Variant> ParseVariant(std::string_view name);

/// What a kernel was read as.
struct Decoded {
  std::uint64_t id = 0;
  std::uint64_t kernel = 0;  ///< the word of the variant that was chosen
  int bits_corrected = 0;    ///< cells in which it differs from what was seen (erased cells do not count)
};

/// The best word for a board's likelihoods.
struct SoftDecoded {
  Decoded best;
  /// Log-likelihood ratio of the best word over the second best, ≥ 0; infinity where there is no second.
  double margin = 0;
};

/// Ids in use, for limiting a decoder. Immutable.
class Roster {
 public:
  /// Sorted and made unique.
  explicit Roster(std::vector<std::uint64_t> ids);
  std::span<const std::uint64_t> ids() const { return ids_; }
  bool Contains(std::uint64_t id) const;

 private:
  std::vector<std::uint64_t> ids_;
};

/// One variant at one size: maps ids to kernels and back. Immutable and cheap to copy; any thread.
class MarkerCode {
 public:
  /// Throws std::runtime_error, saying what is allowed, where the variant does not exist at that size.
  MarkerCode(MarkerSize size, Variant variant);

  /// A table of one's own: entry i is the kernel of id i. Throws std::runtime_error on an empty table, on more than
  /// 65 536 entries, on a kernel with bits beyond the size's, and on two equal ones, naming the entries.
  static MarkerCode FromTable(MarkerSize size, std::vector<std::uint64_t> kernels);

  /// Reads a table from a text file: one kernel a line as KernelBits digits 0 and 1, in the order of ids; blank lines
  /// and what follows # are skipped. Throws std::runtime_error naming file, line and what would be right.
  static MarkerCode LoadTable(MarkerSize size, const std::filesystem::path& path);

  MarkerSize size() const;
  Variant variant() const;
  /// The largest id (ids run from 0).
  std::uint64_t max_id() const;
  /// The least number of cells in which two words of the variant differ; KernelBits + 1 where there is only one word.
  /// Computed at each call for a table (up to a second for a large one).
  int min_distance() const;
  /// Wrong cells that DecodeHard corrects: secded 1, golay 3, nordstrom_robinson 2, reed_muller 3, otherwise 0.
  int guaranteed_radius() const;

  /// The kernel of an id. @pre id ≤ max_id().
  std::uint64_t Encode(std::uint64_t id) const;

  /// Hard decision: the word that is the kernel or lies within the guaranteed radius; nothing otherwise, and nothing
  /// for a number with bits beyond KernelBits.
  std::optional<Decoded> DecodeHard(std::uint64_t kernel) const;

  /// The most likely word: exactly so, for every variant. Where others are just as likely the margin is 0 and any one
  /// of them is returned. Allocates nothing.
  /// @param log_likelihood_ratio KernelBits values, log P(saturated) − log P(unsaturated) of each kernel cell;
  ///   0 for an erased (hidden) cell; finite.
  /// @param roster limits the words to these ids; null: all words. Ids beyond max_id() are passed over. Where the
  ///   same roster is used again and again, RosterDecoder is quicker.
  /// Nothing only when the roster leaves no word. The caller judges the margin and the distance.
  std::optional<SoftDecoded> DecodeSoft(std::span<const float> log_likelihood_ratio,
                                        const Roster* roster = nullptr) const;

 private:
  struct Impl;
  explicit MarkerCode(std::shared_ptr<const Impl> impl);
  /// Shared because a code is immutable and its tables large; copies of a code are one table.
  std::shared_ptr<const Impl> impl_;
};

/// Soft decoding limited to the ids of a roster, their kernels prepared once: a few nanoseconds an id.
/// Immutable, any thread.
class RosterDecoder {
 public:
  /// Ids beyond code.max_id() are passed over.
  RosterDecoder(const MarkerCode& code, const Roster& roster);

  /// As MarkerCode::DecodeSoft with that roster.
  std::optional<SoftDecoded> DecodeSoft(std::span<const float> log_likelihood_ratio) const;

 private:
  int bits_;
  std::vector<std::uint64_t> ids_;      ///< ascending
  std::vector<std::uint64_t> kernels_;  ///< of ids_
};

}  // namespace chequer

#pragma GCC visibility pop
