#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detector.h"
#include "detect/boards/anchor.h"
#include "detect/boards/second_look.h"
#include "detect/boards/twins.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/common/search_regions.h"
#include "detect/common/thread_pool.h"
#include "detect/common/tone_table.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/deferred_places.h"
#include "detect/fit/fit.h"
#include "detect/fit_schedule.h"
#include "detect/grids/grids.h"
#include "detect/identity/identify.h"
#include "detect/memory/expected_boards.h"
#include "detect/memory/memory.h"
#include "detect/tracer.h"
#include "detect/work_plan.h"

namespace chequer {

struct Detector::Impl {
  struct Worker;

  explicit Impl(DetectorOptions given);

  /// A frame of a stream.
  struct StreamFrame {
    FrameTime captured{};
    MemoryState& memory;
  };

  /// @param stream null: an image for itself.
  void Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace,
              const StreamFrame* stream = nullptr);
  /// Places the boards that the memory expects, as if a search had found them there.
  void ExpectBoards(const StreamFrame& stream, const LightReader& reader, const Lens& lens);
  /// Where most of the boards do not show where they are expected, moves all by the shift that they share.
  void FollowShift(const LightReader& reader, const Lens& lens);
  /// Nothing covers it, and all of its corners were found.
  static bool ShowsAllCorners(const AnchoredBoard& board) {
    return std::none_of(board.covered.begin(), board.covered.end(),
                        [](std::uint8_t covered) { return covered != 0; }) &&
           std::all_of(board.found.begin(), board.found.begin() + CornerCount(board.size), [](bool in) { return in; });
  }
  /// Of the first `count` boards, that for which clear(index) and which lies topmost in the image; 0 if there is none.
  /// It tells the image's traits, the same one whether it was found or expected, so that both give all boards the same.
  template <class Clear>
  std::size_t Topmost(std::size_t count, Clear&& clear) const {
    std::size_t first = 0;
    float top = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < count; ++i) {
      const float at = frame->boards[i].box.Center().y();
      if (at >= top || !clear(i)) continue;
      top = at;
      first = i;
    }
    return first;
  }
  /// Makes that board's the first task, unless others wait.
  void LeadWithTopmost(std::span<FitTask> tasks) const;
  /// The first board tells the image's traits: makes it one that shows as it did in the last frame.
  void LeadWithClearest();
  /// Whether a board that was fitted, but not read, keeps its identity.
  bool MayCarry(const StreamFrame& stream, std::size_t expected) const;
  /// Whether the id of a board that was expected is read elsewhere in the image.
  bool ReadElsewhere(std::size_t expected) const;
  /// For the trace: what became of what was expected.
  void TraceExpectations(const StreamFrame& stream, const Lens& lens, Tracer& tracer) const;
  /// Of the boards that were expected and fitted, refuses those that read as others, and notes where the others are to
  /// be searched. @param finally all fits are done: identities are carried.
  void JudgeExpected(const StreamFrame& stream, bool finally, Tracer& tracer);
  /// Whether some of a board's contrast shows where it was expected.
  bool Shows(std::size_t expected) const;
  /// Whether too little of it shows there.
  bool MayLieElsewhere(std::size_t expected) const;
  /// Of the boards that are expected, whether the motion of most is known.
  bool MostAreFollowed() const;
  /// Most of what was expected is not there, and as much was found elsewhere.
  bool IsAnotherPicture() const;
  /// What is searched for boards: the places that are open, and bands of the image in their turn.
  void ChooseRegions(const StreamFrame* stream, const Lens& lens);
  /// What was read lies there, in the regions: nothing else does.
  void MarkKnown(const SearchRegions& regions, const Lens& lens);
  /// Where boards were expected and not searched for, and no fit found and read them: they lie elsewhere. False if
  /// nowhere.
  bool ChooseGivenUp(const Lens& lens);
  /// Searches there, and fits what is found, by what is left of the budget. @param measured the image as boards are
  /// fitted to it.
  void SearchGivenUp(const ImageView& image, const LightReader& reader, const LightReader& measured, const Lens& lens,
                     Tracer& tracer);
  /// That the image is searched in by turns.
  int Bands() const { return std::min(options.search_every, SearchRegions::kMostBands); }
  void SearchIn(const ImageView& image, SearchRegion region, const LightReader& reader, const Lens& lens,
                Tracer& tracer);
  /// How far the camera moved since the last frame, image pixels. What moved all boards by as much may have been either
  /// that or an own motion that was remembered wrongly, which would have to be corrected in every frame from then on:
  /// what leaves the boards slower is likelier.
  Eigen::Vector2d ShiftOfCamera(const Lens& lens) const;
  /// Makes the memory that for the next frame.
  void Remember(const StreamFrame& stream, const Lens& lens);
  /// Whether poses of both families are the same of the same board.
  bool SameSide(int a, int b) const {
    return options.families[static_cast<std::size_t>(a)].CellM() ==
           options.families[static_cast<std::size_t>(b)].CellM();
  }
  /// Width and height of a board's cells: of the marker that it is, or that was followed there.
  /// @param agrees whether it is as the board that was expected.
  Eigen::Vector2d CellOf(const Identity& identity, std::size_t board, bool agrees) const;
  /// How well the place of a board is known before it is fitted.
  BoardFit::Start::Known KnownTo(std::size_t board) const {
    using Known = BoardFit::Start::Known;
    if (board >= frame->expected.size()) return Known::kFound;
    return frame->expected[board].off_px < BoardFit::kNearPredictionPx ? Known::kNear : Known::kPredicted;
  }
  /// Whether what a fitted board says of the image holds for others. One that was predicted may have been fitted where
  /// something else lies.
  bool TellsTraits(std::size_t board) const;
  /// Whether what shows of a board that was expected, and whose identity is not decided, lies where it was expected and
  /// is the remembered one's.
  bool AgreesWithExpected(std::size_t board, const FittedBoard& fitted, const Identity& identity,
                          const Worker& worker) const;
  bool WasRead(std::size_t expected) const {
    const Outcome& outcome = frame->outcomes[expected];
    const RememberedBoard& board = frame->expected[expected];
    return outcome.accepted && outcome.marker.id == board.id && outcome.marker.family == board.family;
  }
  void FindBoards(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// The corners of a grid.
  PixelBox BoxOf(const Grid& grid) const;
  void SortGrids();
  /// What lies there is left for the next image.
  void Defer(const PixelBox& box);
  void Defer(const FitTask& task);
  /// Searches the grids for boards, while the budget's share lasts.
  void AnchorGrids(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// Gathers the points that no board explains.
  void StartSecondLook(const LightReader& reader, Tracer& tracer);
  /// Takes a second look if the budget lasts for it.
  void LookAgain(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// What a look has shown, another may show again, from what is left around it or more clearly: of boards from `known`
  /// on, those that are not new take the place of the others or are forgotten.
  void KeepBetter(std::size_t known, Tracer& tracer);
  /// Of boards that were found twice, by groups of corners that did not hang together, keeps the one that is known
  /// better.
  void RefuseTwins(Tracer& tracer);
  /// Fits the boards from `first` on, while the budget lasts; plainly where there is one: Refine() follows.
  void FitBoards(std::size_t first, const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// Fits those boards that were postponed and are not read elsewhere.
  void FitPostponed(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// Of the tasks, fits those from `first` on.
  void FitTasks(std::size_t first, const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// Whether the last of these boards is blurred by more than its own motion: then all are, and alike.
  bool CameraMoved(std::span<const FitTask> done) const;
  /// Fits boards until one tells the image's traits. Returns how many were fitted.
  std::size_t FitFirst(const LightReader& reader, const Lens& lens, std::span<FitTask> tasks, Tracer& tracer);
  /// Fits a board in full that a plain fit has not found, where the budget lasts for it.
  void FitFully(const FitTask& task, const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// For the next image (MemoryState::traits).
  void RememberTraits(std::optional<ImageTraits>& traits) const;
  /// Of tasks in this order, fits those that the budget lasts for. Returns how many.
  std::size_t FitInRounds(const LightReader& reader, const Lens& lens, bool plain_only, std::span<FitTask> tasks,
                          Tracer& tracer);
  /// Hands on to the others of the image what the first of these boards shows of it: all of it, or motion and dot gain.
  void ShareTraits(std::span<const FitTask> round);
  /// Whether the middle of a board lies on one of the boards from `first` to before `past` that was read and needs no
  /// other fit.
  bool WasReadAt(std::size_t board, std::size_t first, std::size_t past) const;
  /// Whether it lies on a board that was expected and waits for another fit.
  bool WaitsAt(std::size_t board) const;
  /// Fits once more, by all that may be in their way, boards for which the plain fit does not do.
  void Refine(const LightReader& reader, const Lens& lens, Tracer& tracer);
  /// To fit a board plainly.
  FitTask TaskOf(std::size_t board) const;
  void FindMosaic(const ImageView& image, const std::array<float, 256>& table, const Lens& lens,
                  LightReader& reader) const;

  /// Says that the image is still worked on.
  void TellProgress() const {
    if (options.on_progress) options.on_progress();
  }

  /// What one thread needs for itself. Both begin anew with every board.
  struct Worker {
    explicit Worker(const DetectorOptions& options) : identifier(options) {}
    PhotometricFit fit;
    Identifier identifier;
  };
  /// What became of a board.
  struct Outcome {
    bool accepted = false;
    ImageTraits image;
    MarkerPose marker;
    Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
    std::uint64_t kernel = 0;  ///< that the id was read from
    /// Of a board that was expected and is not decided: what shows is the remembered one's.
    bool agrees = false;
    /// So little of it shows that it is one only if its identity is carried.
    bool carried_or_none = false;
    bool carried = false;       ///< its identity is the remembered one's
    bool contradicted = false;  ///< another was read where it was expected
    bool deferred = false;      ///< it was not fitted, or not as it should be
    bool wants_more = false;    ///< only the plain fit was done, and another may explain it better
    WorkMeter work;
  };
  /// How a board is to be fitted.
  struct FitOrder {
    std::size_t board = 0;
    const ImageTraits* image = nullptr;  ///< null: not known yet
    bool plain_only = false;
    std::uint64_t most_units = 0;
  };
  /// Of a board's cells as printed, height over width.
  double CellRatioOf(MarkerSize size) const;
  /// How far inks of boards of that size may lie out of register, along the board's axes, cells.
  Eigen::Vector2d RegisterOf(MarkerSize size) const;
  Outcome Measure(const LightReader& reader, const Lens& lens, const FitOrder& order, Worker& worker,
                  Tracer& tracer) const;

  /// What is remembered from one image to the next, with a budget; empty without.
  struct Memory {
    DeferredPlaces grids, boards;  ///< that were not searched, or not to their end; that were not fitted, or not fully
    std::uint64_t second_look_most = 0;  ///< units of the second look that was left undone; 0: none was
    std::optional<ImageTraits> traits;   ///< see MemoryState
  };

  /// What is known of one image.
  struct Frame {
    std::size_t missing = 0;                ///< of the boards that were expected, those that no fit has found there yet
    std::vector<RememberedBoard> expected;  ///< the first of the boards, one each
    /// Of them, those that are searched for before they are fitted there, as such a fit would take several times as
    /// much.
    std::vector<bool> postponed;
    int frames_on = 1;                      ///< since the last frame of the stream
    FrameTime last_captured{};
    Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< of all boards, from where they were expected
    std::vector<std::size_t> lost;  ///< of the boards that were expected, those that are searched around
    SearchRegions regions;
    SearchRegions given_up;  ///< searched after all fits
    KnownTiles known;
    std::vector<PixelBox> open;  ///< what is to be searched in the next frame in any case
    std::vector<PixelBox> cut;   ///< grids at the ends of regions, which may go on beyond them
    std::vector<RememberedBoard> read;
    std::vector<float> shares;
    float contrast_share = 1;  ///< of what the expected boards showed in the last frame, in the median
    WorkPlan plan{0};
    WorkMeter work;
    Pyramid pyramid;
    std::vector<Corner> corners;
    GridLinker linker;
    Grids grids;
    std::vector<AnchoredBoard> boards;
    SearchRegion region;            ///< that is searched
    std::size_t boards_before = 0;  ///< of that region
    std::vector<Outcome> outcomes;  ///< by board
    std::vector<FitTask> tasks;
    std::optional<ImageTraits> traits;  ///< once a board has told them
    std::optional<ImageTraits> last_traits;  ///< the last image's, if its boards share a dot gain
    bool needs_dot_gain = false;             ///< plain fits, which know of none, find no boards
    // What single steps need.
    std::vector<StrongPoint> strong;
    std::vector<PixelBox> found_in;
    std::vector<SeenBoard> seen;
    std::vector<std::size_t> twins;  ///< of them, those that were seen better elsewhere
  };

  // The same for all images.
  const DetectorOptions options;
  // Begun anew with every image: a result depends on its image and the options alone.
  Scratch<Frame> frame;
  ExpectedBoards expected_boards;
  BoardFinder finder;
  SecondLook second_look;
  std::vector<Worker> workers;
  // Kept from one image to the next.
  ThreadPool pool;           ///< threads, which sleep between images
  Memory memory;             ///< what the budget left undone
  ToneTable tone;            ///< the same curve has the same table
  DetectStats stats;         ///< of the last image, for those who ask
  std::uint64_t budget = 0;  ///< set from outside, for the images to come
};

}  // namespace chequer
