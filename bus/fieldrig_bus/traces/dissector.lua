-- The messages of fieldrig's buses that have no standard format, in Wireshark and tshark.
--
-- They are packets of the link type USER0 with a head: "fieldrig", the version 1, and the name of the family after its
-- length.  Behind it are the bytes of the message as the Python code of the family has them (ring/sercos/message.py,
-- ring/pam/message.py, dualport/message.py, telephone/codec.py, serial/codec.py, signals/codec.py).

local HEAD = "fieldrig\1"
local FAULT = 0xff  -- the first byte of the note of an injected fault

local main = Proto("fieldrig", "fieldrig")
main.fields.family = ProtoField.string("fieldrig.family", "Family")
main.fields.fault = ProtoField.uint32("fieldrig.fault", "Fault", base.DEC)
main.fields.fault_text = ProtoField.string("fieldrig.fault_text", "Text of the fault")

-- ---- SERCOS ring

local SERCOS_KINDS = {[0] = "Cycle", [1] = "ATs", [2] = "AT", [3] = "MST", [4] = "MDT"}
local sercos = Proto("fieldrig_sercos", "fieldrig SERCOS ring")
local sf = sercos.fields
sf.kind = ProtoField.uint8("fieldrig.sercos.kind", "Kind", base.DEC, SERCOS_KINDS)
sf.cycle = ProtoField.uint32("fieldrig.sercos.cycle", "Cycle", base.DEC)
sf.phase = ProtoField.uint8("fieldrig.sercos.phase", "Phase", base.DEC, nil, 0x07)
sf.address = ProtoField.uint8("fieldrig.sercos.address", "Address", base.DEC)
sf.status = ProtoField.uint16("fieldrig.sercos.status", "Drive status", base.HEX)
sf.service = ProtoField.uint16("fieldrig.sercos.service", "Service channel", base.HEX)
sf.data = ProtoField.bytes("fieldrig.sercos.data", "Data")
sf.closed = ProtoField.bool("fieldrig.sercos.closed", "Ring closed")
sf.errors = ProtoField.uint16("fieldrig.sercos.errors", "Telegrams with a wrong FCS", base.DEC)
sf.late = ProtoField.uint16("fieldrig.sercos.late", "Late stations", base.DEC)

local function sercos_mst(buffer, tree)
  if buffer:len() < 2 then return "MST failed" end
  local below = tree:add(sercos, buffer, "MST")
  below:add(sf.address, buffer(0, 1))
  below:add(sf.phase, buffer(1, 1))
  return "MST phase " .. buffer(1, 1):bitfield(5, 3)
end

local function sercos_mdt(buffer, tree)
  if buffer:len() < 1 then return "no MDT" end
  local below = tree:add(sercos, buffer, "MDT")
  below:add(sf.address, buffer(0, 1))
  if buffer:len() > 1 then below:add(sf.data, buffer(1)) end
  return "MDT of " .. buffer:len() .. " bytes"
end

local function sercos_at(buffer, tree)
  if buffer:len() < 1 then return "AT without an address" end
  local address = buffer(0, 1):uint()
  local below = tree:add(sercos, buffer, "AT of drive " .. address)
  below:add(sf.address, buffer(0, 1))
  if buffer:len() >= 5 then
    below:add_le(sf.status, buffer(1, 2))
    below:add_le(sf.service, buffer(3, 2))
  end
  if buffer:len() > 5 then below:add(sf.data, buffer(5)) end
  return "AT " .. address
end

local function sercos_ats(buffer, tree)
  tree:add_le(sf.closed, buffer(5, 1))
  tree:add_le(sf.errors, buffer(6, 2))
  tree:add_le(sf.late, buffer(8, 2))
  local at, names = 10, {}
  while at + 2 <= buffer:len() do
    local length = buffer(at, 2):le_uint()
    if length == 0 or at + 2 + length > buffer:len() then break end
    names[#names + 1] = sercos_at(buffer(at + 2, length), tree)
    at = at + 2 + length
  end
  local open = buffer(5, 1):uint() == 0 and ", ring open" or ""
  return (#names > 0 and table.concat(names, ", ") or "no ATs") .. open
end

local function sercos_cycle(buffer, tree)
  local mst, mdt = buffer(5, 1):uint(), buffer(6, 2):le_uint()
  if 8 + mst + mdt > buffer:len() then return "cut short" end
  local text = mst > 0 and sercos_mst(buffer(8, mst), tree) or "MST failed"
  return text .. ", " .. (mdt > 0 and sercos_mdt(buffer(8 + mst, mdt), tree) or "no MDT")
end

local function ring(buffer, tree)
  local kind = buffer(0, 1):uint()
  tree:add(sf.kind, buffer(0, 1))
  local number = ""
  if kind ~= 2 and kind ~= 4 then
    tree:add_le(sf.cycle, buffer(1, 4))
    number = buffer(1, 4):le_uint() .. " "
  end
  if kind == 0 then return number .. sercos_cycle(buffer, tree) end
  if kind == 1 then return number .. sercos_ats(buffer, tree) end
  if kind == 2 then return buffer:len() > 1 and sercos_at(buffer(1), tree) or "AT without an address" end
  if kind == 3 then return number .. (buffer:len() > 5 and sercos_mst(buffer(5), tree) or "MST failed") end
  if kind == 4 then return buffer:len() > 1 and sercos_mdt(buffer(1), tree) or "no MDT" end
  return "unknown kind " .. kind
end

-- ---- PAM ring

local PAM_KINDS = {[0] = "Frames", [1] = "Cycle", [2] = "Reports", [3] = "Buffer of a node"}
local PAM_RECEPTION = {[0] = "good", [1] = "no carrier", [2] = "wrong CRC"}
local PAM_FRAMES = {
  [0x01] = "Identify", [0x02] = "Run", [0x03] = "Group", [0x04] = "SetOutput", [0x05] = "Blink", [0x06] = "Display",
  [0x07] = "MotorOrder", [0x08] = "AxisOrder", [0x09] = "SetPoint", [0x0a] = "EndOfPipe", [0x0b] = "Read",
  [0x10] = "InputItem", [0x11] = "CounterItem", [0x12] = "KeyItem", [0x13] = "OutputItem", [0x14] = "AnalogItem",
  [0x15] = "LedItem", [0x16] = "SevenSegmentItem", [0x17] = "MotorItem", [0x18] = "AxisItem", [0x81] = "Identity",
  [0x82] = "Accepted", [0x83] = "Refused", [0x84] = "Running", [0x85] = "InputChanged", [0x86] = "Answer",
  [0x87] = "AxisReport", [0x88] = "MotorReport", [0x89] = "Trouble",
}
local PAM_GROUP = 256  -- targets above are groups
local pam = Proto("fieldrig_pamring", "fieldrig PAM ring")
local pf = pam.fields
pf.version = ProtoField.uint8("fieldrig.pamring.version", "Version", base.DEC)
pf.kind = ProtoField.uint8("fieldrig.pamring.kind", "Kind", base.DEC, PAM_KINDS)
pf.cycle = ProtoField.uint32("fieldrig.pamring.cycle", "Cycle", base.DEC)
pf.reception = ProtoField.uint8("fieldrig.pamring.reception", "Reception", base.DEC, PAM_RECEPTION)
pf.place = ProtoField.uint8("fieldrig.pamring.place", "Noticed at node", base.DEC)
pf.late = ProtoField.uint16("fieldrig.pamring.late", "Late nodes", base.DEC)
pf.nodes = ProtoField.bytes("fieldrig.pamring.nodes", "Nodes in the order of the ring")
pf.target = ProtoField.uint16("fieldrig.pamring.target", "Target", base.DEC)
pf.address = ProtoField.uint16("fieldrig.pamring.address", "Address", base.DEC)
pf.frame = ProtoField.uint8("fieldrig.pamring.frame", "Frame", base.HEX, PAM_FRAMES)
pf.data = ProtoField.bytes("fieldrig.pamring.data", "Contents")

local function pam_target(number)
  if number == 0 then return "to all" end
  return number > PAM_GROUP and "to group " .. (number - PAM_GROUP) or "to " .. number
end

local function pam_frame(buffer, tree)
  tree:add(pf.frame, buffer(0, 1))
  if buffer:len() > 1 then tree:add(pf.data, buffer(1)) end
  return PAM_FRAMES[buffer(0, 1):uint()] or string.format("%02Xh", buffer(0, 1):uint())
end

local function pam_frames(buffer, at, tree)
  local texts = {}
  while at + 3 <= buffer:len() do
    local target, length = buffer(at, 2):le_uint(), buffer(at + 2, 1):uint()
    if length == 0 or at + 3 + length > buffer:len() then break end
    local below = tree:add(pam, buffer(at, 3 + length), pam_target(target))
    below:add_le(pf.target, buffer(at, 2))
    texts[#texts + 1] = pam_target(target) .. ": " .. pam_frame(buffer(at + 3, length), below)
    at = at + 3 + length
  end
  return #texts > 0 and table.concat(texts, "; ") or "no frames"
end

local function pam_buffer(buffer, tree)
  local at, texts = 0, {}
  while at + 1 <= buffer:len() do
    local length = buffer(at, 1):uint()
    if length == 0 or at + 1 + length > buffer:len() then break end
    texts[#texts + 1] = pam_frame(buffer(at + 1, length), tree)
    at = at + 1 + length
  end
  return #texts > 0 and table.concat(texts, ", ") or "empty"
end

local function pam_reports(buffer, tree)
  tree:add(pf.reception, buffer(6, 1))
  tree:add(pf.place, buffer(7, 1))
  tree:add_le(pf.late, buffer(8, 2))
  local nodes = buffer(10, 1):uint()
  if nodes > 0 then tree:add(pf.nodes, buffer(11, nodes)) end
  local at, texts = 11 + nodes, {}
  while at + 4 <= buffer:len() do
    local address, length = buffer(at, 2):le_uint(), buffer(at + 2, 2):le_uint()
    if at + 4 + length > buffer:len() then break end
    local below = tree:add(pam, buffer(at, 4 + length), "from " .. address)
    below:add_le(pf.address, buffer(at, 2))
    local text = length > 0 and pam_buffer(buffer(at + 4, length), below) or "empty"
    texts[#texts + 1] = "from " .. address .. ": " .. text
    at = at + 4 + length
  end
  return #texts > 0 and table.concat(texts, "; ") or "no reports"
end

local function pamring(buffer, tree)
  tree:add(pf.version, buffer(0, 1))
  tree:add(pf.kind, buffer(1, 1))
  local kind = buffer(1, 1):uint()
  if kind == 3 then return "report " .. (buffer:len() > 6 and pam_buffer(buffer(6), tree) or "empty") end
  tree:add_le(pf.cycle, buffer(2, 4))
  local number = buffer(2, 4):le_uint() .. " "
  if kind == 0 then return number .. pam_frames(buffer, 6, tree) end
  if kind == 1 then
    tree:add(pf.reception, buffer(6, 1))
    return number .. pam_frames(buffer, 7, tree)
  end
  return kind == 2 and number .. pam_reports(buffer, tree) or number .. "unknown kind " .. kind
end

-- ---- DualPort memory

local memory = Proto("fieldrig_dualport", "fieldrig DualPort memory")
memory.fields.first = ProtoField.uint16("fieldrig.dualport.first", "First word", base.DEC)
memory.fields.word = ProtoField.uint16("fieldrig.dualport.word", "Word", base.HEX)

local function dualport(buffer, tree)
  tree:add(memory.fields.first, buffer(0, 2))
  local words = {}
  for at = 2, buffer:len() - 2, 2 do
    tree:add(memory.fields.word, buffer(at, 2))
    words[#words + 1] = string.format("%04X", buffer(at, 2):uint())
  end
  return "word " .. buffer(0, 2):uint() .. ": " .. table.concat(words, " ")
end

-- ---- telephone and serial lines

local TELEPHONE_KINDS = {
  [0] = "Data", [1] = "Hook", [2] = "Dial", [3] = "Ring", [4] = "Tone", [5] = "Offer", [6] = "Carrier", [7] = "Ready",
}
local TONES = {[0] = "silence", [1] = "dial", [2] = "ringing", [3] = "busy", [4] = "unobtainable"}
local phone = Proto("fieldrig_telephone", "fieldrig telephone")
local tf = phone.fields
tf.kind = ProtoField.uint8("fieldrig.telephone.kind", "Kind", base.DEC, TELEPHONE_KINDS)
tf.is_on = ProtoField.bool("fieldrig.telephone.is_on", "On, off hook, or ready")
tf.text = ProtoField.string("fieldrig.telephone.text", "Digits or caller")
tf.tone = ProtoField.uint8("fieldrig.telephone.tone", "Tone", base.DEC, TONES)
tf.rate = ProtoField.uint32("fieldrig.telephone.rate", "Rate in bit/s", base.DEC)
tf.data = ProtoField.bytes("fieldrig.telephone.data", "Data")

local function telephone(buffer, tree)
  local kind, rest = buffer(0, 1):uint(), buffer:len() > 1 and buffer(1) or nil
  tree:add(tf.kind, buffer(0, 1))
  if rest == nil then return TELEPHONE_KINDS[kind] or "unknown kind " .. kind end
  local is_on = rest(0, 1):uint() ~= 0
  if kind == 0 then
    tree:add(tf.data, rest)
    return rest:len() .. " bytes: " .. tostring(rest:bytes()):sub(1, 48)
  elseif kind == 1 or kind == 7 then
    tree:add(tf.is_on, rest(0, 1))
    if kind == 7 then return is_on and "ready" or "not ready" end
    return is_on and "off hook" or "on hook"
  elseif kind == 2 then
    tree:add(tf.text, rest)
    return "dials " .. rest:string()
  elseif kind == 3 then
    tree:add(tf.is_on, rest(0, 1))
    local caller = rest:len() > 1 and ", from " .. rest(1):string() or ""
    if rest:len() > 1 then tree:add(tf.text, rest(1)) end
    return "ring " .. (is_on and "on" or "off") .. caller
  elseif kind == 4 then
    tree:add(tf.tone, rest(0, 1))
    return "tone: " .. (TONES[rest(0, 1):uint()] or "?")
  elseif kind == 6 and rest:len() >= 4 then
    tree:add_le(tf.rate, rest(0, 4))
    local rate = rest(0, 4):le_uint()
    return rate > 0 and "carrier " .. rate .. " bit/s" or "no carrier"
  end
  tree:add(tf.data, rest)
  return TELEPHONE_KINDS[kind] or "unknown kind " .. kind
end

local SERIAL_KINDS = {[0] = "Data", [1] = "Lines", [2] = "Format", [3] = "Break"}
local line = Proto("fieldrig_serial", "fieldrig serial line")
line.fields.kind = ProtoField.uint8("fieldrig.serial.kind", "Kind", base.DEC, SERIAL_KINDS)
line.fields.dtr = ProtoField.bool("fieldrig.serial.dtr", "DTR", 8, nil, 0x01)
line.fields.rts = ProtoField.bool("fieldrig.serial.rts", "RTS", 8, nil, 0x02)
line.fields.ri = ProtoField.bool("fieldrig.serial.ri", "RI", 8, nil, 0x04)
line.fields.baud = ProtoField.uint32("fieldrig.serial.baud", "Baud", base.DEC)
line.fields.data = ProtoField.bytes("fieldrig.serial.data", "Data")

local function serial(buffer, tree)
  local kind, rest = buffer(0, 1):uint(), buffer:len() > 1 and buffer(1) or nil
  tree:add(line.fields.kind, buffer(0, 1))
  if rest == nil then return SERIAL_KINDS[kind] or "unknown kind " .. kind end
  if kind == 0 then
    tree:add(line.fields.data, rest)
    return rest:len() .. " bytes: " .. tostring(rest:bytes()):sub(1, 48)
  elseif kind == 1 then
    for _, name in ipairs({"dtr", "rts", "ri"}) do tree:add(line.fields[name], rest(0, 1)) end
    local bits = rest(0, 1):uint()
    return "DTR=" .. bits % 2 .. " RTS=" .. math.floor(bits / 2) % 2 .. " RI=" .. math.floor(bits / 4) % 2
  elseif kind == 2 and rest:len() >= 7 then
    tree:add_le(line.fields.baud, rest(0, 4))
    return rest(0, 4):le_uint() .. " " .. rest(4, 1):uint() .. rest(5, 1):string() .. rest(6, 1):uint()
  end
  return SERIAL_KINDS[kind] or "unknown kind " .. kind
end

-- ---- wires

local signals = Proto("fieldrig_wires", "fieldrig wires")
signals.fields.signal = ProtoField.string("fieldrig.wires.signal", "Signal")

local function wires(buffer, tree)
  tree:add(signals.fields.signal, buffer)
  return buffer:string()
end

-- ---- all families

local FAMILIES = {
  ring = {sercos, "SERCOS", ring},
  pamring = {pam, "PAM ring", pamring},
  dualport = {memory, "DualPort", dualport},
  telephone = {phone, "Telephone", telephone},
  serial = {line, "Serial", serial},
  wires = {signals, "Wires", wires},
}

function main.dissector(buffer, packet, tree)
  local head = #HEAD
  if buffer:len() < head + 1 or buffer(0, head):raw() ~= HEAD then return 0 end
  local length = buffer(head, 1):uint()
  if buffer:len() < head + 1 + length then return 0 end
  local below = tree:add(main, buffer(0, head + 1 + length))
  local name = buffer(head + 1, length):string()
  below:add(main.fields.family, buffer(head + 1, length))
  packet.cols.protocol = "fieldrig " .. name
  local at = head + 1 + length
  if buffer:len() == at then return buffer:len() end
  local message, family = buffer(at), FAMILIES[name]
  if message(0, 1):uint() == FAULT and message:len() >= 5 then
    below:add_le(main.fields.fault, message(1, 4))
    local text = message:len() > 5 and message(5):string() or ""
    below:add(main.fields.fault_text, text)
    packet.cols.info = "fault " .. message(1, 4):le_uint() .. ": " .. text
  elseif family ~= nil then
    packet.cols.protocol = family[2]
    local shown = tree:add(family[1], message)
    local is_whole, text = pcall(family[3], message, shown)  -- a message that is cut short raises
    packet.cols.info = is_whole and text or "cut short"
    if not is_whole then shown:add_expert_info(PI_MALFORMED, PI_WARN, "The message is cut short") end
  else
    Dissector.get("data"):call(message:tvb(), packet, tree)
  end
  return buffer:len()
end

DissectorTable.get("wtap_encap"):add(wtap.USER0, main)
