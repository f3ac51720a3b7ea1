#include "firmware/canopen/eds.hpp"

#include <algorithm>
#include <bit>

#include "firmware/canopen/object_dictionary.hpp"

namespace plenum::canopen {
namespace {

constexpr std::uint8_t kVar = 0x7;
constexpr std::uint8_t kArray = 0x8;
constexpr std::uint8_t kRecord = 0x9;
constexpr std::uint8_t kDomainObject = 0x2;

constexpr std::uint8_t kSectionEnd = 10;  ///< the line after the last one of an object's section

// ---- the head: everything before the objects ----

using PutValue = void (*)(TextLine&, const Identity&);

struct HeadLine {
  const char* text;
  PutValue value = nullptr;
};

template <const char* Identity::*member>
void put_text(TextLine& line, const Identity& identity) {
  line.put(identity.*member);
}

template <std::uint32_t Identity::*member>
void put_number(TextLine& line, const Identity& identity) {
  line.put("0x");
  line.hexadecimal(identity.*member, 8);
}

template <std::size_t count>
void put_count(TextLine& line, const Identity&) {
  line.decimal(static_cast<std::int32_t>(count));
}

constexpr std::string_view kComments[] = {
    "CiA 301 node with the pressure control of CiA 408, one module a chamber. Own choices:",
    "6042h knows only 1, the set point over the bus. 6043h: -1 excitation, 3 feedforward, 4 closed loop.",
    "6041h: bit 8 every chamber that watches a target window (63F0h) is within it (own), 9 a ramp runs,",
    "10 a set point touches a limit, 11 a control deviation. 2230h: the same of each chamber.",
    "605Fh: bit m is set where 6043h takes the mode m (own). 6391h: 10 bar are 100 %, in a ramp's times too.",
    "6120h to 6125h: the line of the sensor through both ends of its signal window. Writing one end leaves",
    "the other where it is. They, 63A0h, 63A1h, 63B0h to 63B5h, 63D1h to 63D5h and 63F0h to 63F4h show",
    "2400h.. . What has one value only (6123h, 63A2h to 63A4h, 63B3h, 63B6h, 63C0h to 63C6h, 63E0h to 63E2h)",
    "takes that one and does nothing: the valve's gain, dead band and characteristic are the model's.",
    "6394h is 0 until it is written: what is held is then the pressure at which holding began (own).",
    "Pressures of the 63xxh records are absolute, in mbar, -32768 stands for a pressure that is not known.",
    "A rising edge of R in 6040h resets faults only while the rest of the word asks for no more than",
    "DISABLED, in FAULT_HOLD for no more than HOLD. No reset of node or communication takes a fault away.",
    "While 6040h asks for ACTIVE the event timer of an RPDO is its deadline, and 2419h:2 [ticks, 0: off] one",
    "for all set points together (for SYNC in excitation), the one that ends first counts: EMCY 8250h.",
    "A set point written by SDO feeds 2419h:2 while none has come by PDO in ACTIVE.",
    "A chamber whose set point is older than 2419h:2 when ACTIVE begins goes on as in HOLD until one comes.",
    "A PDO shorter than its mapping changes nothing: EMCY 8210h. Of a longer one the beginning counts:",
    "8220h. A SYNC that 1019h does not allow changes nothing: 8240h.",
    "Mapping, inhibit time and SYNC start value change only while the PDO is switched off: abort 0800 0022h,",
    "another identifier likewise: 0609 0030h. Remote frames are not answered, whatever bit 30 says.",
    "LSS takes bit rates that the board offers, each from its next start on. 15h (activate) is ignored.",
    "1010h:2 keeps 1005h, 1014h, 1016h, 1017h, 1019h, 1029h and the PDOs,",
    "1010h:3 keeps the settings, 2160h, 2228h:2, 6056h and 6394h. A default is what 1011h restores.",
    "A model: a number of one's own to 2121h:1 before each image (may be left out), the image to",
    "2110h + c. When 2128h + c:1 says that it is staged, the mask of chambers to 2120h:1, the CRC-32 of the",
    "images' own CRCs in chamber order to 2120h:2, and 746D6F63h to 2120h:3, which keeps it, too.",
    "0800 0022h: not yet, the key again later. 0800 0020h: no, or nothing is staged. Reset node forgets what",
    "is staged. 2128h + c:2: 1 too short, 2 no image, 3 unknown kind, 4 other schema, 5 count, 6 size,",
    "7 CRC, 8 no number, 9 range, 10 not admissible, 11 commit under way, 13 predicts worse,",
    "14 serial number, 15 staged by another, 16 its inverse fails, 17 no command moves the pressure.",
    "Reset node leaves a frozen log (2300h:4 = 2) as it is, 0 to 2300h:1 lets it roll on.",
    "2830h: byte 2 is 0 none, 1 hold, 2 safe, 3 vent, byte 3 bit 0 of a chamber, bit 1 clears by itself.",
    "REAL32 values and limits are written as decimal numbers.",
    "Settings (2400h.. and what shows them) are written in INIT, FAULT_INIT only: 241Ah tells why not.",
    "Objects 2xxxh are the manufacturer's.",
};

constexpr HeadLine kBeforeComments[] = {
    {"[FileInfo]"},
    {"FileName=plenum.eds"},
    {"FileVersion=1"},
    {"FileRevision=1"},
    {"EDSVersion=4.0"},
    {"Description=Pressure valve board"},
    {"CreationTime=12:00PM"},
    {"CreationDate=11-21-2026"},
    {"CreatedBy=the board"},
    {"ModificationTime=12:00PM"},
    {"ModificationDate=11-21-2026"},
    {"ModifiedBy=the board"},
    {""},
    {"[DeviceInfo]"},
    {"VendorName=", put_text<&Identity::vendor_name>},
    {"VendorNumber=", put_number<&Identity::vendor_id>},
    {"ProductName=", put_text<&Identity::device_name>},
    {"ProductNumber=", put_number<&Identity::product_code>},
    {"RevisionNumber=", put_number<&Identity::revision>},
    {"OrderCode="},
    {"BaudRate_10=1"},
    {"BaudRate_20=1"},
    {"BaudRate_50=1"},
    {"BaudRate_125=1"},
    {"BaudRate_250=1"},
    {"BaudRate_500=1"},
    {"BaudRate_800=1"},
    {"BaudRate_1000=1"},
    {"SimpleBootUpMaster=0"},
    {"SimpleBootUpSlave=1"},
    {"Granularity=8"},
    {"DynamicChannelsSupported=0"},
    {"CompactPDO=0"},
    {"GroupMessaging=0"},
    {"NrOfRXPDO=", put_count<kRpdos>},
    {"NrOfTXPDO=", put_count<kTpdos>},
    {"LSS_Supported=1"},
    {""},
    {"[DummyUsage]"},
    {"Dummy0001=0"},
    {"Dummy0002=0"},
    {"Dummy0003=0"},
    {"Dummy0004=0"},
    {"Dummy0005=0"},
    {"Dummy0006=0"},
    {"Dummy0007=0"},
    {""},
    {"[Comments]"},
    {"Lines=", put_count<std::size(kComments)>},
};

// ---- the objects ----

/// An object: its rows, and which instance of them.
struct Object {
  std::span<const Entry> rows;
  std::uint8_t instance;

  std::uint32_t index() const noexcept { return rows[0].index + std::uint32_t{rows[0].stride} * instance; }
  bool has_subs() const noexcept { return rows.size() > 1 || rows[0].last_sub > 0; }

  const Entry* row_of(unsigned sub) const noexcept {
    for (const Entry& row : rows) {
      if (sub >= row.sub && sub <= row.last_sub) return &row;
    }
    return nullptr;
  }

  std::int32_t sub_count() const noexcept {
    std::int32_t count = 0;
    for (const Entry& row : rows) count += row.last_sub - row.sub + 1;
    return count;
  }

  std::uint8_t type() const noexcept {
    if (!has_subs()) return rows[0].type == DataType::domain ? kDomainObject : kVar;
    // CiA 301 makes records of the PDO mappings, though their members are alike
    const bool is_mapping = index() >= 0x1600 && index() < 0x1C00;
    const bool stores =
        index() == 0x1010 || index() == 0x1011;  // arrays whose members have names of their own
    return stores || (rows.size() == 2 && !is_mapping) ? kArray : kRecord;
  }
};

/// The order of the sheet: row by row of the table, and of a row each instance.
bool to_next_object(std::uint16_t& row, std::uint8_t& instance) noexcept {
  if (++instance >= object_dictionary()[row].instances) {
    instance = 0;
    row = static_cast<std::uint16_t>(row + rows_of_object(row).size());
  }
  return row < object_dictionary().size();
}

void put_instance(TextLine& line, const Object& object) noexcept {
  if (object.rows[0].instances == 1) return;
  const std::uint32_t index = object.index();
  const bool rpdo = index >= 0x1400 && index < 0x1800;
  const bool tpdo = index >= 0x1800 && index < 0x1C00;
  line.put(rpdo ? ", RPDO " : tpdo ? ", TPDO " : ", chamber ");
  line.decimal(object.instance + 1);
}

void put_name(TextLine& line, const Object& object, const Entry& row, unsigned sub) noexcept {
  line.put(row.name);
  if (row.last_sub > row.sub) {
    line.put(" ");
    line.decimal(static_cast<std::int32_t>(sub - row.sub + 1U));
  }
  put_instance(line, object);
}

/// As CiA 306 writes it; seen from the bus, "rwr" may be mapped to a TPDO only.
std::string_view access_name(const Entry& entry) noexcept {
  switch (entry.access) {
    case Access::constant:
      return "const";
    case Access::read_only:
      return "ro";
    case Access::write_only:
      return "wo";
    case Access::read_write:
      return entry.mappable == Mappable::transmit ? "rwr" : "rw";
  }
  return "ro";
}

bool is_signed(DataType type) noexcept {
  return type == DataType::integer8 || type == DataType::integer16 || type == DataType::integer32;
}

}  // namespace

void put_value(TextLine& line, DataType type, std::uint32_t bits) noexcept {
  if (type == DataType::real32) return line.real(std::bit_cast<float>(bits));
  if (is_signed(type)) {
    const std::size_t shift = 32 - 8 * size_of(type);
    return line.decimal(static_cast<std::int32_t>(bits << shift) >> shift);
  }
  line.put("0x");
  line.hexadecimal(bits, static_cast<int>(2 * size_of(type)));
}

DataSheet::DataSheet(const Identity& identity, const config::SettingsDesk& installed, config::ModelDesk& desk,
                     telemetry::Recorder& recorder) noexcept
    : delivered_{.node_id = 0, .identity = identity},
      settings_(installed),
      device_{delivered_, image_, desk, settings_, recorder, *this, delivered_communication(), {}, {}, {}} {
  state_revision(delivered_.identity);
}

std::size_t DataSheet::read(std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept {
  if (offset == 0) {
    marks_[newest_mark_] = {};
    held_marks_ = 1;
    restart({});
  } else if (offset < begun_.offset) {
    go_back(offset);
  }
  if (offset < begun_.offset || offset - begun_.offset > kRepeat) return 0;

  std::size_t done = 0;
  while (done < bytes.size()) {
    const std::size_t from = offset + done - begun_.offset;
    const std::string_view text = line_.text();
    if (from < text.size()) {
      const std::size_t count = std::min(text.size() - from, bytes.size() - done);
      std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(from), count,
                  bytes.begin() + static_cast<std::ptrdiff_t>(done));
      done += count;
    } else if (next_.part == Part::end) {
      break;
    } else {
      advance();
    }
  }
  return done;
}

std::uint32_t DataSheet::size() noexcept {
  if (size_ != 0) return size_;
  Position at;
  while (at.part != Part::end) make_line(at);
  size_ = at.offset;
  restart(begun_);  // the line that was there has been written over
  return size_;
}

void DataSheet::restart(const Position& at) noexcept {
  begun_ = next_ = at;
  line_.clear();
}

/// The mark set `age` marks before the newest one. `age` < held_marks_.
DataSheet::Position& DataSheet::mark(std::size_t age) noexcept {
  return marks_[(newest_mark_ + kMarks - age) % kMarks];
}

/// To the last mark that is not behind `offset`, by halving. What is ahead of it will be marked again.
void DataSheet::go_back(std::uint32_t offset) noexcept {
  std::size_t age = 0;
  for (std::size_t left = held_marks_ - 1; left > 0;) {
    const std::size_t half = (left - 1) / 2;
    if (mark(age + half).offset <= offset) {
      left = half;
    } else {
      age += half + 1;
      left -= half + 1;
    }
  }
  newest_mark_ = (newest_mark_ + kMarks - age) % kMarks;
  held_marks_ -= age;
  restart(mark(0));
}

void DataSheet::advance() noexcept {
  begun_ = next_;
  if (begun_.offset - mark(0).offset >= kMarkEvery) {
    newest_mark_ = (newest_mark_ + 1) % kMarks;
    held_marks_ = std::min(held_marks_ + 1, kMarks);
    mark(0) = begun_;
  }
  make_line(next_);
}

void DataSheet::make_line(Position& at) noexcept {
  line_.clear();
  switch (at.part) {
    case Part::head:
      head_line(at);
      break;
    case Part::mandatory:
    case Part::optional:
    case Part::manufacturer:
      list_line(at);
      break;
    case Part::objects:
      object_line(at);
      break;
    case Part::end:
      break;
  }
  at.offset += static_cast<std::uint32_t>(line_.text().size());
}

void DataSheet::head_line(Position& at) noexcept {
  const std::size_t number = at.number++;
  if (number < std::size(kBeforeComments)) {
    const HeadLine& line = kBeforeComments[number];
    line_.put(line.text);
    if (line.value != nullptr) line.value(line_, delivered_.identity);
  } else if (number < std::size(kBeforeComments) + std::size(kComments)) {
    const std::size_t comment = number - std::size(kBeforeComments);
    line_.put("Line");
    line_.decimal(static_cast<std::int32_t>(comment + 1));
    line_.put("=");
    line_.put(kComments[comment]);
  } else {
    at.part = Part::mandatory;
    at.number = 0;
  }
  line_.put("\n");
}

void DataSheet::list_line(Position& at) noexcept {
  const int group = static_cast<int>(at.part) - static_cast<int>(Part::mandatory);
  const ObjectList list = objects_of(static_cast<ObjectGroup>(group));
  if (at.number == 0) {
    constexpr std::array<std::string_view, 3> kHeader = {"[MandatoryObjects]\n", "[OptionalObjects]\n",
                                                         "[ManufacturerObjects]\n"};
    line_.put(kHeader[static_cast<std::size_t>(group)]);
    ++at.number;
    return;
  }
  if (at.number == 1) {
    line_.put("SupportedObjects=");
    line_.decimal(list.objects);
    line_.put("\n");
    ++at.number;
    return;
  }
  if (at.row < list.first_row.size()) {
    const Entry& row = object_dictionary()[list.first_row[at.row]];
    line_.decimal(at.number - 1);
    line_.put("=0x");
    line_.hexadecimal(row.index + std::uint32_t{row.stride} * at.instance, 4);
    ++at.number;
    if (++at.instance == row.instances) {
      at.instance = 0;
      ++at.row;
    }
  } else {
    at.part = static_cast<Part>(static_cast<int>(at.part) + 1);
    at.row = 0;
    at.instance = 0;
    at.number = 0;
  }
  line_.put("\n");
}

void DataSheet::object_line(Position& at) noexcept {
  const Object object{rows_of_object(at.row), at.instance};
  const Entry& row = *object.row_of(at.sub);
  const bool whole = at.whole && object.has_subs();  // a section without a value
  const bool is_domain = row.type == DataType::domain;
  switch (at.line++) {
    case 0:
      line_.put("[");
      line_.hexadecimal(object.index(), 4);
      if (!at.whole) {
        line_.put("sub");
        line_.hexadecimal(at.sub, 1);
      }
      line_.put("]\n");
      return;
    case 1:
      line_.put("ParameterName=");
      if (whole) {
        line_.put(row.object_name);
        put_instance(line_, object);
      } else {
        put_name(line_, object, row, at.sub);
      }
      break;
    case 2:
      line_.put("ObjectType=0x");
      line_.hexadecimal(whole ? object.type() : is_domain ? kDomainObject : kVar, 1);
      break;
    case 3:
      if (!whole) return;
      line_.put("SubNumber=");
      line_.decimal(object.sub_count());
      at.line = kSectionEnd;
      break;
    case 4:
      line_.put("DataType=0x");
      line_.hexadecimal(static_cast<std::uint32_t>(row.type), 4);
      break;
    case 5:
      line_.put("AccessType=");
      line_.put(access_name(row));
      break;
    case 6:
      if (!row.range.limited) return;
      limit_line("LowLimit=", row, row.range.low);
      break;
    case 7:
      if (!row.range.limited) return;
      limit_line("HighLimit=", row, row.range.high);
      break;
    case 8:
      default_line(row, at.instance, at.sub);
      return;
    case 9:
      if (whole || is_domain) return;
      line_.put(row.mappable == Mappable::no ? "PDOMapping=0" : "PDOMapping=1");
      break;
    default:
      to_next_section(at);
      break;
  }
  line_.put("\n");
}

void DataSheet::to_next_section(Position& at) noexcept {
  const Object object{rows_of_object(at.row), at.instance};
  at.line = 0;
  if (object.has_subs()) {
    unsigned sub = at.whole ? 0 : at.sub + 1U;
    while (sub <= object.rows.back().last_sub && object.row_of(sub) == nullptr) ++sub;
    at.whole = false;
    at.sub = static_cast<std::uint8_t>(sub);
    if (sub <= object.rows.back().last_sub) return;
  }
  at.whole = true;
  at.sub = 0;
  if (!to_next_object(at.row, at.instance)) at.part = Part::end;
}

void DataSheet::limit_line(std::string_view key, const Entry& entry, float limit) noexcept {
  line_.put(key);
  if (entry.type == DataType::real32) return line_.real(limit);
  line_.decimal(static_cast<std::int32_t>(limit));
}

void DataSheet::default_line(const Entry& entry, std::uint8_t instance, std::uint8_t sub) noexcept {
  if (entry.access != Access::constant && entry.kept == Kept::no && !entry.of_node) return;
  line_.put("DefaultValue=");
  if (entry.read_bytes != nullptr) {
    const std::span<const std::uint8_t> text = entry.read_bytes(device_, {instance, sub});
    line_.put({reinterpret_cast<const char*>(text.data()), text.size()});  // a VISIBLE_STRING
  } else {
    std::uint32_t bits = 0;
    // what is constant or kept is never refused
    static_cast<void>(entry.read_value(device_, {instance, sub}, bits));
    if (adds_node_id(entry, bits)) line_.put("$NODEID+");
    put_value(line_, entry.type, bits);
  }
  line_.put("\n");
}

}  // namespace plenum::canopen
