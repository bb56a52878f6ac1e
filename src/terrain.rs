//! A terrain model: the height of the ground from a GeoTIFF.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use crate::projection::{LonLat, utm};

/// Why a file is no terrain model that can be used.
#[derive(Debug, thiserror::Error)]
pub enum TerrainError {
    /// It is no TIFF, or one of a kind that cannot be read.
    #[error("it cannot be read as TIFF: {0}")]
    Tiff(#[from] TiffError),
    /// It does not say where it lies.
    #[error("it has no {0}, so that nobody knows where it lies")]
    NoPlace(&'static str),
    /// It holds something other than heights.
    #[error("it holds {0}, not one height for each place")]
    NoHeights(String),
    /// Its coordinates are not known here.
    #[error(
        "its coordinates are {0}; degrees (EPSG:4326, 4258, 4269) and UTM (EPSG:326xx, 327xx, 258xx) are understood"
    )]
    Coordinates(String),
}

/// What the columns and rows of the file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Frame {
    /// Longitude and latitude, degrees.
    Degrees,
    /// East and north in a zone of UTM, metres.
    Utm { zone: u8, south: bool },
}

/// Heights on a grid, metres.
#[derive(Clone, Debug)]
pub struct Terrain {
    frame: Frame,
    size: [usize; 2],
    /// Row by row.
    heights: Vec<f32>,
    /// The value that marks unknown heights.
    void: Option<f32>,
    /// From a place of the frame to column and row: origin, then the rows of a matrix.
    origin: [f64; 2],
    inverse: [[f64; 2]; 2],
}

/// GeoTIFF's keys and their values that matter here.
mod key {
    pub const MODEL: u16 = 1024;
    pub const RASTER: u16 = 1025;
    pub const GEOGRAPHIC: u16 = 2048;
    pub const PROJECTED: u16 = 3072;
    pub const VERTICAL_UNIT: u16 = 4099;
    pub const MODEL_PROJECTED: u16 = 1;
    pub const MODEL_GEOGRAPHIC: u16 = 2;
    pub const PIXEL_IS_POINT: u16 = 2;
    pub const METRE: u16 = 9001;
}

impl Terrain {
    /// Reads the first image of a GeoTIFF.
    ///
    /// # Errors
    ///
    /// If the file is no GeoTIFF, or lies in a projection that is not supported.
    pub fn read(bytes: &[u8]) -> Result<Self, TerrainError> {
        let mut file = Decoder::new(Cursor::new(bytes))?;
        let (width, height) = file.dimensions()?;
        let size = [width as usize, height as usize];
        let keys = file.find_tag_unsigned_vec::<u16>(Tag::GeoKeyDirectoryTag)?;
        let keys = keys.ok_or(TerrainError::NoPlace("GeoKeyDirectory"))?;
        let of = |wanted: u16| {
            keys.chunks_exact(4).skip(1).find_map(|key| match *key {
                [key, 0, _, value] if key == wanted => Some(value),
                _ => None,
            })
        };
        let frame = frame(of)?;
        if let Some(unit) = of(key::VERTICAL_UNIT).filter(|unit| *unit != key::METRE) {
            return Err(TerrainError::NoHeights(format!("heights in the unit EPSG:{unit}, not metres")));
        }
        let (origin, matrix) = affine(&mut file)?;
        let [[a, b], [c, d]] = matrix;
        let det = a * d - b * c;
        if det == 0.0 || !det.is_finite() {
            return Err(TerrainError::NoPlace("grid of any size"));
        }
        let inverse = [[d / det, -b / det], [-c / det, a / det]];
        // A value is the height at a point, or at the middle of a cell.
        let middle = if of(key::RASTER) == Some(key::PIXEL_IS_POINT) { 0.0 } else { 0.5 };
        let origin = [origin[0] + (a + b) * middle, origin[1] + (c + d) * middle];
        let colours = file.colortype()?;
        if !matches!(colours, ColorType::Gray(_)) {
            return Err(TerrainError::NoHeights(format!("a picture ({colours:?})")));
        }
        let void = file.find_tag(Tag::GdalNodata)?.and_then(|value| value.into_string().ok());
        let void = void.and_then(|text| text.trim_matches(['\0', ' ']).parse::<f32>().ok());
        let heights = heights(file.read_image()?)?;
        if heights.len() != size[0] * size[1] || heights.is_empty() {
            return Err(TerrainError::NoHeights(format!("{} values for {width} by {height} places", heights.len())));
        }
        Ok(Self { frame, size, heights, void, origin, inverse })
    }

    /// Height of each place, metres, between the four values around it; `None` beyond the file's edge and where the file
    /// knows nothing.
    pub fn at(&self, places: &[LonLat]) -> Vec<Option<f64>> {
        match self.frame {
            Frame::Degrees => places.iter().map(|place| self.sample([place.lon, place.lat])).collect(),
            Frame::Utm { zone, south } => {
                let north = if south { FALSE_NORTHING } else { 0.0 };
                let points = utm(zone, places).into_iter();
                points.map(|point| point.and_then(|p| self.sample([p.x, p.y + north]))).collect()
            }
        }
    }

    fn sample(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let [dx, dy] = [x - self.origin[0], y - self.origin[1]];
        let [columns, rows] = self.size;
        let [to_column, to_row] = self.inverse;
        let cell = |[a, b]: [f64; 2], count: usize| -> Option<(usize, usize, f64)> {
            let (at, last) = (a * dx + b * dy, (count - 1) as f64);
            // The squares at the edge reach half their size beyond the middle.
            (-0.5..=last + 0.5).contains(&at).then(|| {
                let at = at.clamp(0.0, last);
                let low = at.floor() as usize;
                (low, (low + 1).min(count - 1), at - at.floor())
            })
        };
        let ((left, right, across), (top, bottom, down)) = (cell(to_column, columns)?, cell(to_row, rows)?);
        let corner = |column: usize, row: usize, weight: f64| {
            let height = *self.heights.get(row * columns + column)?;
            match weight > 0.0 {
                true => (height.is_finite() && Some(height) != self.void).then(|| f64::from(height) * weight),
                false => Some(0.0),
            }
        };
        Some(
            corner(left, top, (1.0 - across) * (1.0 - down))?
                + corner(right, top, across * (1.0 - down))?
                + corner(left, bottom, (1.0 - across) * down)?
                + corner(right, bottom, across * down)?,
        )
    }
}

/// Northings of UTM's southern half begin at this, metres.
const FALSE_NORTHING: f64 = 1e7;

/// The coordinates that the keys name.
fn frame(of: impl Fn(u16) -> Option<u16>) -> Result<Frame, TerrainError> {
    let utm = |zone: u16, south: bool| Ok(Frame::Utm { zone: zone as u8, south });
    match (of(key::MODEL), of(key::GEOGRAPHIC), of(key::PROJECTED)) {
        (Some(key::MODEL_GEOGRAPHIC), Some(4326 | 4258 | 4269), _) => Ok(Frame::Degrees),
        (Some(key::MODEL_PROJECTED), _, Some(code @ 32601..=32660)) => utm(code - 32600, false),
        (Some(key::MODEL_PROJECTED), _, Some(code @ 32701..=32760)) => utm(code - 32700, true),
        (Some(key::MODEL_PROJECTED), _, Some(code @ 25828..=25838)) => utm(code - 25800, false),
        (Some(key::MODEL_PROJECTED), _, Some(code)) | (_, Some(code), None) => {
            Err(TerrainError::Coordinates(format!("EPSG:{code}")))
        }
        _ => Err(TerrainError::Coordinates("not given by an EPSG code".to_owned())),
    }
}

/// Where column 0, row 0 begins, and how the place changes with column and row.
fn affine(file: &mut Decoder<Cursor<&[u8]>>) -> Result<([f64; 2], [[f64; 2]; 2]), TerrainError> {
    let mut numbers = |tag| -> Result<Option<Vec<f64>>, TerrainError> {
        Ok(file.find_tag(tag)?.map(|value| value.into_f64_vec()).transpose()?)
    };
    if let Some([a, b, _, x, c, d, _, y, ..]) = numbers(Tag::ModelTransformationTag)?.as_deref() {
        return Ok(([*x, *y], [[*a, *b], [*c, *d]]));
    }
    let (scale, tie) = (numbers(Tag::ModelPixelScaleTag)?, numbers(Tag::ModelTiepointTag)?);
    match (scale.as_deref(), tie.as_deref()) {
        (Some([sx, sy, ..]), Some([i, j, _, x, y, ..])) => Ok(([x - i * sx, y + j * sy], [[*sx, 0.0], [0.0, -sy]])),
        _ => Err(TerrainError::NoPlace("ModelTransformation, and no ModelPixelScale with ModelTiepoint")),
    }
}

fn heights(image: DecodingResult) -> Result<Vec<f32>, TerrainError> {
    Ok(match image {
        DecodingResult::F32(values) => values,
        DecodingResult::F64(values) => values.into_iter().map(|v| v as f32).collect(),
        DecodingResult::I16(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::U16(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::I32(values) => values.into_iter().map(|v| v as f32).collect(),
        DecodingResult::I8(values) => values.into_iter().map(f32::from).collect(),
        DecodingResult::U8(values) => values.into_iter().map(f32::from).collect(),
        _ => return Err(TerrainError::NoHeights("numbers of an unusual kind".to_owned())),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::{TiffEncoder, colortype::Gray32Float};

    /// Two columns and two rows: 10, 20 in the north, 30, 50 in the south.
    fn file(keys: &[u16], tie: [f64; 2], scale: [f64; 2]) -> Vec<u8> {
        let mut out = Cursor::new(Vec::new());
        let mut tiff = TiffEncoder::new(&mut out).unwrap();
        let mut image = tiff.new_image::<Gray32Float>(2, 2).unwrap();
        let tags = image.encoder();
        tags.write_tag(Tag::ModelPixelScaleTag, &[scale[0], scale[1], 0.0][..]).unwrap();
        tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, tie[0], tie[1], 0.0][..]).unwrap();
        tags.write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
        tags.write_tag(Tag::GdalNodata, "-9999").unwrap();
        image.write_data(&[10.0, 20.0, 30.0, 50.0]).unwrap();
        out.into_inner()
    }

    const DEGREES: [u16; 16] = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326];

    fn at(terrain: &Terrain, lon: f64, lat: f64) -> Option<f64> {
        terrain.at(&[LonLat { lon, lat }])[0]
    }

    #[test]
    fn heights_lie_between_the_middles_of_the_squares() {
        let terrain = Terrain::read(&file(&DEGREES, [8.0, 50.0], [1.0, 1.0])).unwrap();
        assert_eq!(at(&terrain, 8.5, 49.5), Some(10.0));
        assert_eq!(at(&terrain, 9.5, 48.5), Some(50.0));
        assert_eq!(at(&terrain, 9.0, 49.0), Some(27.5));
        assert_eq!(at(&terrain, 8.1, 49.9), Some(10.0), "the square reaches to its edge");
        assert_eq!(at(&terrain, 7.9, 49.5), None);
    }

    #[test]
    fn a_value_may_stand_for_its_place() {
        let mut keys = DEGREES;
        keys[11] = 2;
        let terrain = Terrain::read(&file(&keys, [8.0, 50.0], [1.0, 1.0])).unwrap();
        assert_eq!(at(&terrain, 8.0, 50.0), Some(10.0));
        assert_eq!(at(&terrain, 8.5, 49.5), Some(27.5));
    }

    #[test]
    fn utm_north_and_south() {
        for (code, lat, north) in [(32632, 50.0, 0.0), (32732, -50.0, FALSE_NORTHING)] {
            let place = LonLat { lon: 9.0, lat };
            let point = utm(32, &[place])[0].unwrap();
            let keys = [1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, code];
            let terrain = Terrain::read(&file(&keys, [point.x - 10.0, point.y + north + 10.0], [10.0, 10.0])).unwrap();
            let found = at(&terrain, 9.0, lat).unwrap();
            assert!((found - 27.5).abs() < 1e-3, "{found}");
        }
    }

    #[test]
    fn what_cannot_be_placed_is_refused() {
        let error = |keys: &[u16]| Terrain::read(&file(keys, [0.0; 2], [1.0; 2])).unwrap_err().to_string();
        assert!(error(&[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 2056]).contains("EPSG:2056"));
        assert!(error(&[1, 1, 0, 1, 1024, 0, 1, 3]).contains("EPSG code"));
        assert!(Terrain::read(b"no picture").is_err());
        let feet = [1, 1, 0, 3, 1024, 0, 1, 2, 2048, 0, 1, 4326, 4099, 0, 1, 9003];
        assert!(error(&feet).contains("9003"));
    }
}
