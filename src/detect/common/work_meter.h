#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace chequer {

/// Steps of the detector's work, which are counted as they are done.
enum class WorkStep : std::uint8_t {
  kFrame,           ///< an image is begun
  kPixel,           ///< a pixel of a plane: conversion, halvings, corner response
  kPeak,            ///< a peak of the response is looked at
  kCorner,          ///< a corner is sorted, linked and walked over
  kNeighbourGroup,  ///< a group of corners is held against the rays of another
  kLink,            ///< an edge is looked for along a link
  kGrid,            ///< a grid is begun
  kLatticePoint,    ///< a point of a grid's lattice is set up
  kLatticeSearch,   ///< a corner is looked for at a point of the lattice
  kComparison,      ///< a point is held against a place, or a placement against another
  kFitPoint,        ///< a point in a homography
  kCellSample,      ///< the light of a cell is measured
  kWindow,          ///< a board is tried at a place and turn of a lattice
  kWindowCell,      ///< one of its cells is held against its neighbours
  kJudgement,       ///< the inks of its border are judged
  kBorderCell,      ///< one of these cells
  kBoard,           ///< a board is placed
  kInkProbe,        ///< the inks around a strong point are measured
  kPlace,           ///< what changes around a point is followed
  kViewPixel,       ///< a pixel of a second view
  kCollectedPixel,  ///< a pixel of a board is copied, and prepared for a fit
  kFitStep,         ///< a step of a board's fit by the four cells around each corner …
  kFitPixel,        ///< … and a pixel in it
  kModelCorner,     ///< a corner in a step of a fit of the whole model …
  kModelPixel,      ///< … a pixel in it …
  kModelTap,        ///< … and a pixel at one point of a motion
  kMixedPixel,      ///< a pixel of cells that are read together is shared out to them
  kReading,         ///< a fitted board's identity and pose are told
  kCount,
};

/// Counts the work on an image. It never looks at a clock: the same image counts the same in every run, on every
/// machine and with any number of threads.
class WorkMeter {
 public:
  static constexpr std::uint64_t kInstructionsPerUnit = 1000;
  static constexpr std::size_t kSteps = static_cast<std::size_t>(WorkStep::kCount);

  /// Instructions that a step takes on an x86-64 processor with AVX2, of BGR images: fitted to what callgrind counts
  /// (tests/bench/work_check, which says how well they fit).
  static constexpr std::array<std::uint32_t, kSteps> kInstructions = [] {
    std::array<std::uint32_t, kSteps> table{};
    const auto set = [&](WorkStep step, std::uint32_t cost) { table[static_cast<std::size_t>(step)] = cost; };
    set(WorkStep::kFrame, 100'000);
    set(WorkStep::kPixel, 5);
    set(WorkStep::kPeak, 550);
    set(WorkStep::kCorner, 950);
    set(WorkStep::kNeighbourGroup, 112);
    set(WorkStep::kLink, 190);
    set(WorkStep::kGrid, 3'000);
    set(WorkStep::kLatticePoint, 60);
    set(WorkStep::kLatticeSearch, 290);
    set(WorkStep::kComparison, 21);
    set(WorkStep::kFitPoint, 270);
    set(WorkStep::kCellSample, 520);
    set(WorkStep::kWindow, 700);
    set(WorkStep::kWindowCell, 150);
    set(WorkStep::kJudgement, 800);
    set(WorkStep::kBorderCell, 165);
    set(WorkStep::kBoard, 17'000);
    set(WorkStep::kInkProbe, 1'450);
    set(WorkStep::kPlace, 36'000);
    set(WorkStep::kViewPixel, 80);
    set(WorkStep::kCollectedPixel, 40);
    set(WorkStep::kFitStep, 85'000);
    set(WorkStep::kFitPixel, 30);
    set(WorkStep::kModelCorner, 15'000);
    set(WorkStep::kModelPixel, 394);
    set(WorkStep::kModelTap, 40);
    set(WorkStep::kMixedPixel, 700);  // by its loops' lengths, not yet fitted
    set(WorkStep::kReading, 50'000);
    return table;
  }();

  static constexpr std::uint32_t Instructions(WorkStep step) { return kInstructions[static_cast<std::size_t>(step)]; }

  void Add(WorkStep step, std::uint64_t times = 1) { times_[static_cast<std::size_t>(step)] += times; }
  /// Takes over what another meter counted of the same image.
  void Add(const WorkMeter& other) {
    for (std::size_t i = 0; i < kSteps; ++i) times_[i] += other.times_[i];
  }
  std::uint64_t times(WorkStep step) const { return times_[static_cast<std::size_t>(step)]; }
  std::uint64_t units() const {
    std::uint64_t instructions = 0;
    for (std::size_t i = 0; i < kSteps; ++i) instructions += times_[i] * kInstructions[i];
    return instructions / kInstructionsPerUnit;
  }

 private:
  std::array<std::uint64_t, kSteps> times_{};
};

}  // namespace chequer
