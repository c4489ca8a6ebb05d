module bw_measured_notes
  !! What a reader of measured waves must know, in words.
  use bw_kinds, only: dp
  use bw_line_peaks, only: peak_type
  use bw_mode_numbering, only: curve_type, mode_type
  use bw_text, only: append, shortest, string, text_of
  implicit none (type, external)
  private
  public :: measured_notes

  real(dp), parameter :: worth_a_note = 1.0e-6_dp  !! growth over the record

contains

  pure function measured_notes(peaks, modes, curve, uniform, listed, folded, samples, duration) result(notes)
    !! One note for each kind of thing found.
    type(peak_type), intent(in) :: peaks(:)
    type(mode_type), intent(in) :: modes(:)
    type(curve_type), intent(in) :: curve
    logical, intent(in) :: uniform             !! modes were looked for
    integer, intent(in) :: listed(:)           !! peaks in the result
    integer, intent(in) :: folded(:)           !! modes that peaks are folded images of, 0: none
    integer, intent(in) :: samples
    real(dp), intent(in) :: duration           !! s
    type(string), allocatable :: notes(:)
    logical :: stray(size(peaks))
    integer :: i
    allocate (notes(0))
    if (any(folded > 0)) call note(notes, 'folded back from above half the sampling rate ('// &
      & shortest(samples/(2*duration), 6)//' Hz) and left out: modes '//list([(text(folded(i)), i=1, size(folded))]))
    stray = curve%support > 0 .and. modes%number == 0 .and. folded == 0 .and. peaks%members == 1 &
      & .and. peaks%located .and. .not. peaks%at_edge
    if (uniform .and. all(modes%number == 0) .and. size(peaks) > 0) call note(notes, &
      & 'the peaks cannot be numbered as modes: wave numbers and velocities are missing, and any line may be folded')
    if (.not. all(peaks%located)) call note(notes, 'lines that could not be told apart, left out: '// &
      & frequencies(.not. peaks%located))
    if (any(stray)) call note(notes, 'lines that fit no mode, left out: '//frequencies(stray))
    if (any(peaks%members > 1 .and. peaks%located)) call note(notes, &
      & 'lines closer than 1/duration, each group taken as one: '//frequencies(peaks%members > 1 .and. peaks%located))
    if (any(peaks%at_edge .and. peaks%located)) call note(notes, &
      & 'lines at 0 or at half the sampling rate, known to 1/duration only: '// &
      & frequencies(peaks%at_edge .and. peaks%located))
    if (any(abs(peaks%growth) > worth_a_note)) call note(notes, &
      & 'lines that grow or decay: '//frequencies(abs(peaks%growth) > worth_a_note))
    if (size(listed) < count(.not. stray .and. folded == 0 .and. peaks%located)) call note(notes, &
      & 'only the '//text_of(size(listed))//' strongest peaks are listed')

  contains

    pure function frequencies(chosen) result(words)
      !! `12.5, 80 Hz` of the chosen peaks.
      logical, intent(in) :: chosen(:)
      character(:), allocatable :: words
      type(string) :: frequency(size(chosen))
      integer :: j
      do j = 1, size(chosen)
        frequency(j)%text = ''
        if (chosen(j)) frequency(j)%text = shortest(peaks(j)%position/duration, 6)
      end do
      words = list(frequency)//' Hz'
    end function frequencies

  end function measured_notes

  pure type(string) function text(number)
    !! The number, nothing for 0.
    integer, intent(in) :: number
    text%text = ''
    if (number > 0) text%text = text_of(number)
  end function text

  pure function list(items) result(words)
    !! The items that are not empty, with commas.
    type(string), intent(in) :: items(:)
    character(:), allocatable :: words
    integer :: i
    words = ''
    do i = 1, size(items)
      if (len(items(i)%text) == 0) cycle
      if (len(words) > 0) words = words//', '
      words = words//items(i)%text
    end do
  end function list

  pure subroutine note(notes, words)
    type(string), allocatable, intent(inout) :: notes(:)
    character(*), intent(in) :: words
    call append(notes, words)
  end subroutine note

end module bw_measured_notes
