#include "tools/convert_job.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "core/suggestion.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

template <typename Enum, std::size_t count>
using Words = std::array<std::pair<std::string_view, Enum>, count>;

constexpr Words<FrameFileKind, 3> kKinds{
    {{"png", FrameFileKind::kPng}, {"jpeg", FrameFileKind::kJpeg}, {"raw", FrameFileKind::kRaw}}};
constexpr Words<YuvRange, 2> kRanges{{{"full", YuvRange::kFull}, {"limited", YuvRange::kLimited}}};
constexpr Words<ChromaSharing, 3> kChromas{
    {{"444", ChromaSharing::k444}, {"422", ChromaSharing::k422}, {"420", ChromaSharing::k420}}};

[[noreturn]] void Refuse(const std::string& option, const std::string& why) { throw CLI::ValidationError(option, why); }

template <typename Enum, std::size_t count>
Enum ParseWord(const std::string& option, const std::string& word, const Words<Enum, count>& words) {
  std::vector<std::string> known;
  for (const auto& [name, value] : words) {
    if (word == name) return value;
    known.emplace_back(name);
  }
  std::string allowed;
  for (const std::string& name : known) allowed.append(allowed.empty() ? "" : ", ").append(name);
  Refuse(option, word + ": must be one of " + allowed + DidYouMean(word, known));
}

PixelFormat ParseFormat(const std::string& option, const std::string& name) {
  const auto format = ParsePixelFormat(name);
  if (!format)
    Refuse(option, name + ": must be one of " + PixelFormatNames() + DidYouMean(name, WordsOf(PixelFormatNames())));
  return *format;
}

bool IsPlanarYuv(PixelFormat format) {
  return format == PixelFormat::kYuv420p || format == PixelFormat::kYuv422p || format == PixelFormat::kYuv444p;
}

Recording OpenInput(const ConvertRequest& request) {
  PlainImageOptions plain;
  plain.jpeg_colour = JpegColour::kBgr;
  if (request.pixel_format && IsPlanarYuv(ParseFormat("--pixel-format", *request.pixel_format)))
    plain.jpeg_colour = JpegColour::kYuv;
  if (request.fps) plain.fps = *request.fps;
  if (!(plain.fps >= 0.001 && plain.fps <= 10000)) Refuse("--fps", "must be from 0.001 to 10000");
  if (request.one_channel) plain.one_channel = ParseFormat("--one-channel", *request.one_channel);
  if (plain.one_channel != PixelFormat::kMono8 && !IsBayer(plain.one_channel))
    Refuse("--one-channel", *request.one_channel + ": must be Mono8, BayerRG8, BayerGB8, BayerGR8 or BayerBG8");
  if (request.gamma && !(*request.gamma >= 0.2 && *request.gamma <= 5)) Refuse("--gamma", "must be from 0.2 to 5");
  if (request.gamma) plain.tone_curve = ToneCurve::Gamma(*request.gamma);
  if (request.inputs.size() == 1) return OpenRecording(request.inputs.front(), plain);
  for (const std::string& input : request.inputs)
    if (fs::is_directory(input)) Refuse("input", input + " is a folder: of several inputs each must be an image");
  return RecordingOfImages({request.inputs.begin(), request.inputs.end()}, plain);
}

void CheckPlainOptions(const ConvertRequest& request, const Recording& input) {
  if (input.folder.empty()) return;
  const char* given = request.fps           ? "--fps"
                      : request.one_channel ? "--one-channel"
                      : request.gamma       ? "--gamma"
                                            : nullptr;
  if (given != nullptr) Refuse(given, "is for images alone: a recording says it itself");
}

std::size_t ParseIndex(const std::string& frames, std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    Refuse("--frames", frames + ": must be FIRST-LAST or one number, counted from 0, such as 100-199");
  return value;
}

void PlanFrames(const ConvertRequest& request, ConvertJob& job) {
  const std::size_t count = job.input.frames.size();
  job.last = count - 1;
  job.every = request.every;
  if (job.every < 1) Refuse("--every", "must be at least 1");
  if (request.frames.empty()) return;
  const std::string_view text = request.frames;
  const std::size_t dash = std::min(text.find('-'), text.size());
  job.first = ParseIndex(request.frames, text.substr(0, dash));
  job.last = dash == text.size() ? job.first : ParseIndex(request.frames, text.substr(dash + 1));
  if (job.first > job.last || job.last >= count)
    Refuse("--frames", request.frames + ": must lie in 0-" + std::to_string(count - 1));
}

/// A file if the name says so, else a folder.
ConvertTarget PlanTarget(const ConvertRequest& request, const ConvertJob& job) {
  if (!HasImageExtension(request.out)) return request.images_only ? ConvertTarget::kImages : ConvertTarget::kRecording;
  std::string extension = fs::path(request.out).extension().string();
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg")
    Refuse("--out", request.out + ": an image is written as .png, .jpg or .jpeg");
  if (job.first != job.last)
    Refuse("--out", request.out + " is one image, the input has " + std::to_string(job.last - job.first + 1) +
                        " frames: choose one with --frames, or name a folder");
  return ConvertTarget::kOneImage;
}

FrameFileKind PlanKind(const ConvertRequest& request, const ConvertJob& job) {
  const RecordingInfo& info = job.info;
  if (job.target == ConvertTarget::kOneImage) {
    if (request.files) Refuse("--files", "is for folders: the name of an image says its kind");
    return KindOf(request.out);
  }
  if (request.files) return ParseWord("--files", *request.files, kKinds);
  if (request.quality || request.chroma) return FrameFileKind::kJpeg;
  const FrameFileKind as_before = KindOf(job.input.frames.front().file);
  for (const FrameFileKind kind : {as_before, FrameFileKind::kPng}) {
    const bool is_image = kind != FrameFileKind::kRaw || job.target == ConvertTarget::kRecording;
    if (is_image && CheckFrameFiles(kind, info.pixel_format, info.yuv_range).empty()) return kind;
  }
  return FrameFileKind::kRaw;
}

void PlanFormat(const ConvertRequest& request, ConvertJob& job) {
  job.info = job.input.info;
  RecordingInfo& info = job.info;
  if (request.pixel_format) {
    info.pixel_format = ParseFormat("--pixel-format", *request.pixel_format);
  } else if (job.target != ConvertTarget::kRecording) {
    // Images are for looking at and for other programs: what they cannot hold is made colour.
    const bool fits = CheckFrameFiles(FrameFileKind::kPng, info.pixel_format, info.yuv_range).empty();
    if (!fits) info.pixel_format = PixelFormat::kBgr8;
  }
  if (!IsYuv(job.input.info.pixel_format)) info.yuv_range = YuvRange::kFull;
  if (request.yuv_range) {
    if (!IsYuv(info.pixel_format)) Refuse("--yuv-range", "needs a YUV --pixel-format");
    info.yuv_range = ParseWord("--yuv-range", *request.yuv_range, kRanges);
  }
  if (!SizeIsValid(info.pixel_format, info.width, info.height))
    Refuse("--pixel-format", std::string(PixelFormatName(info.pixel_format)) +
                                 " needs an even width, NV12 an even height too; the frames are " +
                                 std::to_string(info.width) + " x " + std::to_string(info.height));
}

void PlanFiles(const ConvertRequest& request, ConvertJob& job) {
  job.files.kind = PlanKind(request, job);
  if (job.target == ConvertTarget::kImages && job.files.kind == FrameFileKind::kRaw)
    Refuse("--files", "raw files are no images: leave out --images");
  const std::string wrong = CheckFrameFiles(job.files.kind, job.info.pixel_format, job.info.yuv_range);
  if (!wrong.empty()) Refuse(job.target == ConvertTarget::kOneImage ? "--out" : "--files", wrong);
  if (job.files.kind != FrameFileKind::kJpeg && (request.quality || request.chroma))
    Refuse(request.quality ? "--quality" : "--chroma", "is for JPEG files: add --files jpeg");
  if (request.quality) job.files.jpeg.quality = *request.quality;
  if (job.files.jpeg.quality < 1 || job.files.jpeg.quality > 100) Refuse("--quality", "must be from 1 to 100");
  if (request.chroma) job.files.jpeg.chroma = ParseWord("--chroma", *request.chroma, kChromas);
  const RecordingInfo &before = job.input.info, &after = job.info;
  job.may_copy_files = before.pixel_format == after.pixel_format &&
                       (!IsYuv(after.pixel_format) || before.yuv_range == after.yuv_range) && !request.quality &&
                       !request.chroma;
}

void PlanCompanions(const ConvertRequest& request, ConvertJob& job) {
  const Recording& input = job.input;
  if (job.target != ConvertTarget::kRecording && (request.camera || request.calibration))
    Refuse(request.camera ? "--camera" : "--calibration", "is for recordings: images hold no such thing");
  if (request.camera) job.info.camera = *request.camera;
  if (job.info.camera.empty() || job.info.camera.size() > 100) Refuse("--camera", "must have 1 to 100 characters");
  if (request.calibration) job.calibration = *request.calibration;
  if (!request.calibration && !input.info.calibration.empty()) job.calibration = input.folder / input.info.calibration;
  if (!input.info.truth.empty()) job.truth = input.folder / input.info.truth;
  job.info.calibration = job.calibration ? "camera.toml" : "";
  job.info.truth = job.truth ? "truth.jsonl" : "";
}

}  // namespace

FrameFileKind KindOf(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension == ".jpg" || extension == ".jpeg") return FrameFileKind::kJpeg;
  return extension == ".raw" ? FrameFileKind::kRaw : FrameFileKind::kPng;
}

ConvertJob PlanConvert(const ConvertRequest& request) {
  ConvertJob job;
  job.out = request.out;
  job.input = OpenInput(request);
  CheckPlainOptions(request, job.input);
  PlanFrames(request, job);
  job.target = PlanTarget(request, job);
  PlanFormat(request, job);
  PlanFiles(request, job);
  PlanCompanions(request, job);
  return job;
}

}  // namespace chequer
