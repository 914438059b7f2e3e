"""A .vsix file: a ZIP file in the Open Packaging Conventions (ECMA-376, part 2) with the manifest of a VSIX.

The format is that of Visual Studio Code's own packer: `[Content_Types].xml` gives the types of the files by their
endings, `extension.vsixmanifest` what a gallery shows, and the folder `extension` has the files.  Two packs of the same
files are the same bytes.
"""

import io
import zipfile
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any, Final
from xml.sax.saxutils import escape, quoteattr

_TYPES: Final = {
    ".js": "application/javascript",
    ".json": "application/json",
    ".md": "text/markdown",
    ".vsixmanifest": "text/xml",
}
_EARLIEST: Final = (1980, 1, 1, 0, 0, 0)
"""The first date that a ZIP file can have."""
_MANIFEST: Final = """\
<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id={name} Version={version} Publisher={publisher}/>
    <DisplayName>{title}</DisplayName>
    <Description xml:space="preserve">{about}</Description>
    <Categories>{categories}</Categories>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value={engine}/>
    </Properties>
  </Metadata>
  <Installation>
    <InstallationTarget Id="Microsoft.VisualStudio.Code"/>
  </Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.Details" Path="extension/README.md" Addressable="true"/>
  </Assets>
</PackageManifest>
"""


def vsix(manifest: Mapping[str, Any], files: Mapping[str, bytes]) -> bytes:
    """Return the bytes of a .vsix file with these files in its folder `extension`."""
    content = {
        "extension.vsixmanifest": _described(manifest).encode(),
        "[Content_Types].xml": _types(files).encode(),
        **{f"extension/{name}": data for name, data in files.items()},
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(zipfile.ZipInfo(name, _EARLIEST), data, zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _described(manifest: Mapping[str, Any]) -> str:
    return _MANIFEST.format(
        **{name: quoteattr(manifest[name]) for name in ("name", "version", "publisher")},
        title=escape(manifest["displayName"]),
        about=escape(manifest["description"]),
        categories=escape(",".join(manifest["categories"])),
        engine=quoteattr(manifest["engines"]["vscode"]),
    )


def _types(files: Mapping[str, bytes]) -> str:
    endings = sorted({PurePosixPath(name).suffix for name in files} | {".vsixmanifest"})
    defaults = "".join(f'<Default Extension="{end[1:]}" ContentType="{_TYPES[end]}"/>' for end in endings)
    head = '<?xml version="1.0" encoding="utf-8"?>\n'
    return f'{head}<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">{defaults}</Types>\n'
