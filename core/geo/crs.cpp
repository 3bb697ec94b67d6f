// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/crs.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_frmts.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"

namespace cornice {
namespace {

constexpr std::uint16_t kModelTypeKey = 1024;
constexpr std::uint16_t kRasterTypeKey = 1025;
constexpr std::uint16_t kGeographicTypeKey = 2048;
constexpr std::uint16_t kProjectedTypeKey = 3072;
constexpr std::uint16_t kVerticalTypeKey = 4096;
constexpr std::uint16_t kVerticalCitationKey = 4097;
constexpr std::uint16_t kVerticalUnitsKey = 4099;
constexpr int kKeysTag = 34735;
constexpr int kDoublesTag = 34736;
constexpr int kAsciiTag = 34737;

/// A name under /vsimem that no other thread has, removed at the end.
class MemoryFile {
 public:
  MemoryFile() {
    static std::atomic<std::uint64_t> counter{0};
    name_ = "/vsimem/cornice_crs_" + std::to_string(counter++) + ".tif";
  }
  ~MemoryFile() { VSIUnlink(name_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const char* name() const { return name_.c_str(); }

 private:
  std::string name_;
};

void register_geotiff_driver() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (GDALGetDriverByName("GTiff") == nullptr) GDALRegister_GTiff();
  });
}

int epsg_code(const OGRSpatialReference& srs, const char* node) {
  const char* authority = srs.GetAuthorityName(node);
  const char* code = srs.GetAuthorityCode(node);
  if (authority == nullptr || code == nullptr || !EQUAL(authority, "EPSG")) return 0;
  return std::atoi(code);
}

/// Confidence from which PROJ says that the definitions are equivalent and only names differ
/// (documentation of proj_identify).
constexpr int kEquivalentConfidence = 70;

/// 0 where PROJ finds no equal in its database, or several that are equally good.
int best_match(const OGRSpatialReference& horizontal) {
  int count = 0;
  int* confidence = nullptr;
  OGRSpatialReferenceH* matches =
      OSRFindMatches(OGRSpatialReference::ToHandle(const_cast<OGRSpatialReference*>(&horizontal)),
                     nullptr, &count, &confidence);
  int code = 0;
  int best = kEquivalentConfidence;
  bool ambiguous = false;
  for (int i = 0; i < count && confidence[i] >= best; ++i) {
    const int candidate = epsg_code(*OGRSpatialReference::FromHandle(matches[i]), nullptr);
    if (candidate == 0) continue;
    ambiguous = code != 0 && candidate != code;
    if (ambiguous) break;
    code = candidate;
    best = confidence[i];
  }
  OSRFreeSRSArray(matches);
  CPLFree(confidence);
  return ambiguous ? 0 : code;
}

/// EPSG code of a horizontal CRS that carries none or a wrong one; 0 where there is none.
int identify_epsg(const OGRSpatialReference& horizontal) {
  const int code = best_match(horizontal);
  if (code != 0 || !horizontal.IsProjected()) return code;
  // PROJ before 9.2 looks no further where it knows the name, though for something else: a system
  // in feet may bear that of its namesake in metres.
  OGRSpatialReference nameless(horizontal);
  nameless.SetNode("PROJCS", "unknown");
  OGR_SRSNode* root = nameless.GetRoot();
  if (root == nullptr) return 0;
  if (const int id = root->FindChild("AUTHORITY"); id >= 0) root->DestroyChild(id);
  return best_match(nameless);
}

/// The code itself where its definition has the unit of `horizontal`, else 0: files name the code
/// of a system in metres and store feet.
int confirmed_epsg(int code, const OGRSpatialReference& horizontal) {
  if (code == 0 || !horizontal.IsProjected()) return code;
  OGRSpatialReference defined;
  if (defined.importFromEPSG(code) != OGRERR_NONE) return 0;
  constexpr double kTolerance = 1e-9;
  return std::abs(defined.GetLinearUnits() - horizontal.GetLinearUnits()) < kTolerance ? code : 0;
}

/// The CRS without its vertical part.
OGRSpatialReference horizontal_part(const OGRSpatialReference& srs) {
  OGRSpatialReference horizontal(srs);
  horizontal.StripVertical();
  return horizontal;
}

std::string wkt_of(const OGRSpatialReference& srs) {
  for (const char* format : {"FORMAT=WKT1_GDAL", "FORMAT=WKT2_2019"}) {
    const char* options[] = {format, nullptr};
    char* text = nullptr;
    const OGRErr failure = srs.exportToWkt(&text, options);
    std::string wkt = text != nullptr ? text : "";
    CPLFree(text);
    if (failure == OGRERR_NONE && !wkt.empty()) return wkt;
  }
  return {};
}

/// The value of a parsed CRS; nothing where it has no horizontal part.
std::optional<Crs> describe(OGRSpatialReference srs) {
  const bool vertical_only = srs.IsVertical() && !srs.IsCompound();
  if (srs.IsEmpty() || vertical_only) return std::nullopt;
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  Crs crs;
  crs.wkt = wkt_of(srs);
  if (crs.wkt.empty()) return std::nullopt;
  crs.name = srs.GetName() != nullptr ? srs.GetName() : "";
  crs.projected = srs.IsProjected() != 0;
  crs.has_vertical = srs.IsCompound() || (srs.IsGeographic() && srs.GetAxesCount() == 3);
  const OGRSpatialReference horizontal = srs.IsCompound() ? horizontal_part(srs) : srs;
  crs.horizontal_epsg = confirmed_epsg(epsg_code(horizontal, nullptr), horizontal);
  if (crs.horizontal_epsg == 0 && (srs.IsProjected() || srs.IsGeographic())) {
    crs.horizontal_epsg = identify_epsg(horizontal);
  }
  crs.metres_per_unit = srs.IsGeographic() ? 0.0 : horizontal.GetLinearUnits();
  if (srs.IsCompound()) {
    crs.vertical_epsg = epsg_code(srs, "COMPD_CS|VERT_CS");
    crs.vertical_metres_per_unit = srs.GetTargetLinearUnits("VERT_CS");
  } else if (crs.projected) {
    crs.vertical_metres_per_unit = crs.metres_per_unit;
  }
  return crs;
}

bool is_padding(char c) { return c == '\0' || std::isspace(static_cast<unsigned char>(c)) != 0; }

std::string without_padding(const std::string& text) {
  std::size_t begin = 0;
  // A record of 1.4 ends at its first zero byte; what follows is padding or rubbish.
  std::size_t end = std::min(text.size(), std::strlen(text.c_str()));
  while (begin < end && is_padding(text[begin])) ++begin;
  while (end > begin && is_padding(text[end - 1])) --end;
  return text.substr(begin, end - begin);
}

void put16(std::vector<unsigned char>& out, std::uint32_t value) {
  out.push_back(static_cast<unsigned char>(value & 0xff));
  out.push_back(static_cast<unsigned char>((value >> 8) & 0xff));
}
void put32(std::vector<unsigned char>& out, std::uint32_t value) {
  put16(out, value & 0xffff);
  put16(out, value >> 16);
}
std::uint16_t get16(const unsigned char* bytes) {
  return static_cast<std::uint16_t>(bytes[0] | (bytes[1] << 8));
}
std::uint32_t get32(const unsigned char* bytes) {
  return get16(bytes) | (static_cast<std::uint32_t>(get16(bytes + 2)) << 16);
}

enum TiffType : std::uint16_t { kTiffAscii = 2, kTiffShort = 3, kTiffLong = 4, kTiffDouble = 12 };

struct TiffEntry {
  int tag = 0;
  TiffType type = kTiffShort;
  std::uint32_t count = 0;
  std::vector<unsigned char> data;
};

TiffEntry tiff_number(int tag, TiffType type, std::uint32_t value) {
  TiffEntry entry{tag, type, 1, {}};
  put32(entry.data, value);
  return entry;
}

/// A TIFF of one black pixel that carries the given GeoTIFF records, so that GDAL's own reader
/// turns them into a CRS.
std::vector<unsigned char> tiff_with_records(const GeotiffRecords& records) {
  std::vector<TiffEntry> entries;
  for (int tag : {256, 257}) entries.push_back(tiff_number(tag, kTiffLong, 1));  // width, height
  entries.push_back(tiff_number(258, kTiffShort, 8));                            // bits per sample
  entries.push_back(tiff_number(259, kTiffShort, 1));                            // not compressed
  entries.push_back(tiff_number(262, kTiffShort, 1));                            // black is zero
  entries.push_back(tiff_number(273, kTiffLong, 8));                             // strip offset
  entries.push_back(tiff_number(277, kTiffShort, 1));                            // samples
  entries.push_back(tiff_number(278, kTiffLong, 1));                             // rows per strip
  entries.push_back(tiff_number(279, kTiffLong, 1));                             // strip bytes
  entries.push_back(
      {kKeysTag, kTiffShort, static_cast<std::uint32_t>(records.keys.size() / 2), records.keys});
  if (records.doubles.size() >= 8) {
    entries.push_back({kDoublesTag, kTiffDouble,
                       static_cast<std::uint32_t>(records.doubles.size() / 8), records.doubles});
  }
  if (!records.ascii.empty()) {
    TiffEntry ascii{kAsciiTag, kTiffAscii, 0, {records.ascii.begin(), records.ascii.end()}};
    ascii.data.push_back(0);
    ascii.count = static_cast<std::uint32_t>(ascii.data.size());
    entries.push_back(std::move(ascii));
  }
  // Header, the pixel (padded to 8 bytes), the directory, then values longer than 4 bytes.
  constexpr std::uint32_t kDirectory = 16;
  std::vector<unsigned char> tiff = {'I', 'I', 42, 0, kDirectory, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  std::vector<unsigned char> values;
  const auto values_at = static_cast<std::uint32_t>(kDirectory + 2 + entries.size() * 12 + 4);
  put16(tiff, static_cast<std::uint32_t>(entries.size()));
  for (TiffEntry& entry : entries) {
    put16(tiff, static_cast<std::uint32_t>(entry.tag));
    put16(tiff, entry.type);
    put32(tiff, entry.count);
    if (entry.data.size() <= 4) {
      entry.data.resize(4);
      tiff.insert(tiff.end(), entry.data.begin(), entry.data.end());
    } else {
      put32(tiff, values_at + static_cast<std::uint32_t>(values.size()));
      values.insert(values.end(), entry.data.begin(), entry.data.end());
      if (values.size() % 2 != 0) values.push_back(0);
    }
  }
  put32(tiff, 0);
  tiff.insert(tiff.end(), values.begin(), values.end());
  return tiff;
}

/// Value of a short key of record 34735; 0 where it is absent.
std::uint16_t short_key(const std::vector<unsigned char>& keys, std::uint16_t wanted) {
  for (std::size_t at = 8; at + 8 <= keys.size(); at += 8) {
    if (get16(&keys[at]) == wanted && get16(&keys[at + 2]) == 0) return get16(&keys[at + 6]);
  }
  return 0;
}

bool has_key(const std::vector<unsigned char>& keys, std::uint16_t wanted) {
  for (std::size_t at = 8; at + 8 <= keys.size(); at += 8) {
    if (get16(&keys[at]) == wanted) return true;
  }
  return false;
}

/// EPSG's code of a vertical system that a file names by GeoTIFF 1.0's list (section 6.3.4.1),
/// whose codes 5101 to 5106 are those of the datums in EPSG; other codes as they are.
std::uint16_t vertical_system(std::uint16_t code, std::uint16_t unit) {
  constexpr std::uint16_t kNavd88 = 5103, kFoot = 9002, kSurveyFoot = 9003;
  if (code == kNavd88 && unit == kFoot) return 8228;
  if (code == kNavd88 && unit == kSurveyFoot) return 6360;
  return code >= 5101 && code <= 5106 ? static_cast<std::uint16_t>(code + 600) : code;
}

/// The keys in order and each once, without empty ones and without what runs past the record: GDAL
/// refuses a whole directory for any of these, which real writers leave.
std::vector<unsigned char> repaired_keys(const std::vector<unsigned char>& keys) {
  if (keys.size() < 16) return {};
  const std::size_t held = keys.size() / 8 - 1;
  const std::size_t count = std::min<std::size_t>(held, get16(&keys[6]));
  std::map<std::uint16_t, std::size_t> places;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = 8 + i * 8;
    if (get16(&keys[at]) != 0) places.emplace(get16(&keys[at]), at);
  }
  if (places.empty()) return {};
  std::vector<unsigned char> repaired(keys.begin(), keys.begin() + 6);
  put16(repaired, static_cast<std::uint32_t>(places.size()));
  for (const auto& [key, at] : places) {
    for (std::size_t i = 0; i < 8; ++i) repaired.push_back(keys[at + i]);
    if (key != kVerticalTypeKey || get16(&keys[at + 2]) != 0) continue;
    repaired.erase(repaired.end() - 2, repaired.end());
    put16(repaired, vertical_system(get16(&keys[at + 6]), short_key(keys, kVerticalUnitsKey)));
  }
  return repaired;
}

double vertical_unit_in_metres(std::uint16_t epsg_unit) {
  switch (epsg_unit) {
    case 9001:
      return 1.0;
    case 9002:
      return 0.3048;  // international foot
    case 9003:
      return 1200.0 / 3937.0;  // US survey foot
    default:
      return 0.0;
  }
}

/// Values of one tag of a little-endian TIFF's first directory; empty where it is absent.
std::vector<unsigned char> tiff_values(const unsigned char* tiff, std::size_t size, int tag) {
  if (size < 8) return {};
  const std::size_t directory = get32(tiff + 4);
  if (directory + 2 > size) return {};
  const std::size_t count = get16(tiff + directory);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = directory + 2 + i * 12;
    if (at + 12 > size) return {};
    if (get16(tiff + at) != tag) continue;
    const std::uint16_t type = get16(tiff + at + 2);
    const std::size_t width = type == kTiffDouble ? 8 : type == kTiffShort ? 2 : 1;
    const std::size_t bytes = width * get32(tiff + at + 4);
    const std::size_t begin = bytes <= 4 ? at + 8 : get32(tiff + at + 8);
    if (begin > size || bytes > size - begin) return {};
    return {tiff + begin, tiff + begin + bytes};
  }
  return {};
}

OGRSpatialReference parsed(const std::string& wkt) {
  OGRSpatialReference srs;
  srs.importFromWkt(wkt.c_str());
  srs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return srs;
}

bool same_by_proj(const OGRSpatialReference& a, const OGRSpatialReference& b) {
  const char* options[] = {"CRITERION=EQUIVALENT", "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                           nullptr};
  return a.IsSame(&b, options) != 0;
}

bool same_vertical(const Crs& a, const Crs& b) {
  if (a.vertical_epsg != 0 && b.vertical_epsg != 0) return a.vertical_epsg == b.vertical_epsg;
  const OGRSpatialReference whole_a = parsed(a.wkt);
  const OGRSpatialReference whole_b = parsed(b.wkt);
  // OSR compares whole systems only; with equal horizontal parts the vertical one decides.
  if (a.horizontal_epsg == b.horizontal_epsg && same_by_proj(whole_a, whole_b)) return true;
  const char* name_a = whole_a.GetAttrValue("COMPD_CS|VERT_CS");
  const char* name_b = whole_b.GetAttrValue("COMPD_CS|VERT_CS");
  return name_a != nullptr && name_b != nullptr && EQUAL(name_a, name_b);
}

}  // namespace

std::string Crs::text() const {
  if (horizontal_epsg == 0 || (has_vertical && vertical_epsg == 0)) return wkt;
  std::string code = "EPSG:" + std::to_string(horizontal_epsg);
  if (vertical_epsg != 0) code += "+" + std::to_string(vertical_epsg);
  return code;
}

Crs crs_from_text(const std::string& text) {
  const QuietGdal quiet;
  const char* const accepted = "give EPSG:2056+5728, EPSG:2154, WKT or a PROJ string";
  const std::string trimmed = without_padding(text);
  OGRSpatialReference srs;
  const char* limits[] = {"ALLOW_NETWORK_ACCESS=NO", "ALLOW_FILE_ACCESS=NO", nullptr};
  const OGRErr failure =
      trimmed.empty() ? OGRERR_CORRUPT_DATA : srs.SetFromUserInput(trimmed.c_str(), limits);
  if (failure != OGRERR_NONE) {
    throw UsageError("--crs", "'" + trimmed + "' is no known CRS; " + accepted);
  }
  std::optional<Crs> crs = srs.IsGeocentric() ? std::nullopt : describe(srs);
  if (!crs) throw UsageError("--crs", "'" + trimmed + "' has no map or lat/lon axes; " + accepted);
  return *crs;
}

std::optional<Crs> crs_from_wkt(const std::string& wkt) {
  const QuietGdal quiet;
  const std::string trimmed = without_padding(wkt);
  OGRSpatialReference srs;
  if (trimmed.empty() || srs.importFromWkt(trimmed.c_str()) != OGRERR_NONE) return std::nullopt;
  return describe(srs);
}

std::optional<Crs> crs_from_geotiff_keys(const std::vector<unsigned char>& keys,
                                         const std::vector<unsigned char>& doubles,
                                         const std::string& ascii) {
  const QuietGdal quiet;
  register_geotiff_driver();
  const std::vector<unsigned char> repaired = repaired_keys(keys);
  if (repaired.empty()) return std::nullopt;
  std::vector<unsigned char> tiff = tiff_with_records({repaired, doubles, ascii});
  const MemoryFile file;
  VSIFCloseL(VSIFileFromMemBuffer(file.name(), tiff.data(), tiff.size(), FALSE));
  // Files before GeoTIFF 1.1 may say a vertical CRS too; GDAL drops it unless told.
  const CPLConfigOptionSetter with_vertical("GTIFF_REPORT_COMPD_CS", "YES", false);
  const char* const drivers[] = {"GTiff", nullptr};
  const DatasetPtr dataset(
      GDALOpenEx(file.name(), GDAL_OF_RASTER | GDAL_OF_INTERNAL, drivers, nullptr, nullptr));
  if (!dataset) return std::nullopt;
  const OGRSpatialReferenceH handle = GDALGetSpatialRef(dataset.get());
  if (handle == nullptr) return std::nullopt;
  OGRSpatialReference srs(*OGRSpatialReference::FromHandle(handle));
  // A unit of heights alone becomes a vertical system without a name.
  const bool names_vertical =
      short_key(repaired, kVerticalTypeKey) != 0 || has_key(repaired, kVerticalCitationKey);
  if (srs.IsCompound() && !names_vertical) srs = horizontal_part(srs);
  // A citation alone becomes a local CRS: a name without any meaning on the ground.
  if (horizontal_part(srs).IsLocal()) return std::nullopt;
  std::optional<Crs> crs = describe(srs);
  const double unit = vertical_unit_in_metres(short_key(repaired, kVerticalUnitsKey));
  if (crs && !crs->has_vertical && unit > 0.0) crs->vertical_metres_per_unit = unit;
  return crs;
}

std::vector<unsigned char> geotiff_keys_from_crs(const Crs& crs) {
  if (crs.horizontal_epsg <= 0 || crs.horizontal_epsg > 65535) return {};
  if (crs.has_vertical && (crs.vertical_epsg <= 0 || crs.vertical_epsg > 65535)) return {};
  const std::uint32_t horizontal = static_cast<std::uint32_t>(crs.horizontal_epsg);
  std::vector<std::array<std::uint32_t, 2>> entries = {
      {kModelTypeKey, crs.projected ? 1u : 2u},
      {kRasterTypeKey, 1u},
      {crs.projected ? kProjectedTypeKey : kGeographicTypeKey, horizontal}};
  if (crs.has_vertical) {
    entries.push_back({kVerticalTypeKey, static_cast<std::uint32_t>(crs.vertical_epsg)});
  }
  std::vector<unsigned char> keys;
  for (std::uint32_t value : {1u, 1u, 0u}) put16(keys, value);  // version 1, revision 1.0
  put16(keys, static_cast<std::uint32_t>(entries.size()));
  for (const auto& [key, value] : entries) {
    for (std::uint32_t field : {key, 0u, 1u, value}) put16(keys, field);
  }
  return keys;
}

GeotiffRecords geotiff_records_from_crs(const Crs& crs) {
  GeotiffRecords records;
  if (crs.empty()) return records;
  records.keys = geotiff_keys_from_crs(crs);
  if (!records.keys.empty()) return records;
  const QuietGdal quiet;
  register_geotiff_driver();
  const MemoryFile file;
  {
    const DatasetPtr dataset(
        GDALCreate(GDALGetDriverByName("GTiff"), file.name(), 1, 1, 1, GDT_Byte, nullptr));
    if (!dataset) return records;
    const OGRSpatialReference srs = parsed(crs.wkt);
    if (GDALSetSpatialRef(dataset.get(), OGRSpatialReference::ToHandle(
                                             const_cast<OGRSpatialReference*>(&srs))) != CE_None) {
      return records;
    }
  }
  vsi_l_offset size = 0;
  const unsigned char* tiff = VSIGetMemFileBuffer(file.name(), &size, FALSE);
  if (tiff == nullptr) return records;
  records.keys = tiff_values(tiff, size, kKeysTag);
  records.doubles = tiff_values(tiff, size, kDoublesTag);
  const std::vector<unsigned char> ascii = tiff_values(tiff, size, kAsciiTag);
  records.ascii.assign(ascii.begin(), ascii.end());
  return records;
}

bool same_crs(const Crs& a, const Crs& b) {
  if (a.empty() || b.empty()) return a.empty() && b.empty();
  if (a.wkt == b.wkt) return true;
  const QuietGdal quiet;
  if (a.horizontal_epsg != 0 && b.horizontal_epsg != 0) {
    if (a.horizontal_epsg != b.horizontal_epsg) return false;
  } else if (!same_by_proj(horizontal_part(parsed(a.wkt)), horizontal_part(parsed(b.wkt)))) {
    return false;
  }
  return !a.has_vertical || !b.has_vertical || same_vertical(a, b);
}

}  // namespace cornice
