#include "capture/png.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <stdexcept>
#include <string>

#include "capture/codec_limits.h"
#include "chequer/check.h"

// libpng reports errors by longjmp, which must not pass over anything with a destructor. Hence each function that
// calls setjmp does nothing else than libpng's calls, on state that lives outside of it.

namespace chequer {
namespace {

// More than one byte of text or profile a pixel is no photograph; a compressed chunk can promise gigabytes.
constexpr png_alloc_size_t kMaxChunkBytes = 8u << 20;

struct ErrorText {
  char text[200] = "";
};

void OnError(png_structp png, png_const_charp message) {
  auto* error = static_cast<ErrorText*>(png_get_error_ptr(png));
  std::strncpy(error->text, message, sizeof error->text - 1);
  png_longjmp(png, 1);
}

/// libpng warns of what changes no pixel (odd profiles, unknown dates).
void OnWarning(png_structp, png_const_charp) {}

/// A reader over bytes in memory.
struct PngReader {
  explicit PngReader(std::span<const std::uint8_t> bytes) : rest(bytes) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &error, OnError, OnWarning);
    CHEQUER_CHECK(png != nullptr, "libpng could not start");
    info = png_create_info_struct(png);
    CHEQUER_CHECK(info != nullptr, "libpng could not start");
    png_set_read_fn(png, this, Read);
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  static void Read(png_structp png, png_bytep to, std::size_t count) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->rest.size()) png_error(png, "it is truncated");
    std::memcpy(to, reader->rest.data(), count);
    reader->rest = reader->rest.subspan(count);
  }

  ErrorText error;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::span<const std::uint8_t> rest;
};

bool ReadHeader(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  // Nothing that changes no pixel is looked at: less to go wrong in files from anywhere.
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_set_chunk_malloc_max(reader.png, kMaxChunkBytes);
  png_set_user_limits(reader.png, 0x7fffffff, 0x7fffffff);  // the caller checks, with a message that says more
  png_read_info(reader.png, reader.info);
  return true;
}

/// One channel stays one, everything else becomes BGR.
bool SetUpTransforms(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  const png_byte colour = png_get_color_type(reader.png, reader.info);
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(reader.png);
  if (colour == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(reader.png);
  png_set_strip_alpha(reader.png);
  png_set_bgr(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  return true;
}

bool ReadRows(PngReader& reader, png_bytepp rows) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_image(reader.png, rows);
  png_read_end(reader.png, nullptr);
  return true;
}

struct PngWriter {
  PngWriter() {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error, OnError, OnWarning);
    CHEQUER_CHECK(png != nullptr, "libpng could not start");
    info = png_create_info_struct(png);
    CHEQUER_CHECK(info != nullptr, "libpng could not start");
    png_set_write_fn(png, this, Write, nullptr);
  }
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  static void Write(png_structp png, png_bytep from, std::size_t count) {
    auto* writer = static_cast<PngWriter*>(png_get_io_ptr(png));
    writer->bytes.insert(writer->bytes.end(), from, from + count);
  }

  ErrorText error;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint8_t> bytes;
};

bool WriteRows(PngWriter& writer, const ImageView& image, png_bytepp rows) {
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  const bool colour = image.format() == PixelFormat::kBgr8;
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(image.width()),
               static_cast<png_uint_32>(image.height()), 8, colour ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(writer.png, 1);
  png_set_filter(writer.png, 0, PNG_FILTER_SUB);
  png_write_info(writer.png, writer.info);
  png_set_bgr(writer.png);
  png_write_image(writer.png, rows);
  png_write_end(writer.png, nullptr);
  return true;
}

}  // namespace

Image ImageFromPng(std::span<const std::uint8_t> bytes, ToneCurve tone_curve) {
  PngReader reader(bytes);
  if (!ReadHeader(reader)) throw std::runtime_error(reader.error.text);
  const png_uint_32 width = png_get_image_width(reader.png, reader.info);
  const png_uint_32 height = png_get_image_height(reader.png, reader.info);
  CheckPromisedSize(width, height);
  if (png_get_bit_depth(reader.png, reader.info) > 8)
    throw std::runtime_error("it has 16 bits a sample; only 8 are read, and scaling would change what was measured");
  if (!SetUpTransforms(reader)) throw std::runtime_error(reader.error.text);
  const bool grey = png_get_channels(reader.png, reader.info) == 1;
  Image image(grey ? PixelFormat::kMono8 : PixelFormat::kBgr8, static_cast<int>(width), static_cast<int>(height),
              tone_curve);
  std::vector<png_bytep> rows(height);
  for (png_uint_32 y = 0; y < height; ++y)
    rows[y] = image.bytes().data() + std::size_t{y} * png_get_rowbytes(reader.png, reader.info);
  if (!ReadRows(reader, rows.data())) throw std::runtime_error(reader.error.text);
  return image;
}

bool PngHolds(PixelFormat format) {
  return format == PixelFormat::kBgr8 || format == PixelFormat::kMono8 || IsBayer(format);
}

std::vector<std::uint8_t> PngFromImage(const ImageView& image) {
  CHEQUER_CHECK(PngHolds(image.format()), "PNG cannot hold that format");
  PngWriter writer;
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.height()));
  // libpng only reads the rows that it writes from; its interface predates const.
  for (int y = 0; y < image.height(); ++y) rows[static_cast<std::size_t>(y)] = const_cast<png_bytep>(image.row(y));
  if (!WriteRows(writer, image, rows.data()))
    throw std::runtime_error(std::string("encoding a PNG: ") + writer.error.text);
  return std::move(writer.bytes);
}

}  // namespace chequer
